"""The convex narrow phase of one step, compiled only where two shapes without a closed form come near each other."""

from collections.abc import Callable

from plumbline.engine.compile.jit import entry, kernel, template
from plumbline.engine.contact.look_ahead import look_ahead, thinnest
from plumbline.engine.maths.rows import Floats, Ints, Vec, store3
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import pairs_of, rules_of
from plumbline.engine.narrow.collide import is_convex_pair, ordered
from plumbline.engine.narrow.convex import convex_contact, plane_contact
from plumbline.engine.narrow.gjk import Simplex, simplex_of
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.support import Solids, solids_of

HANDICAP = 1e-3
"""Share of the thinner shape's half thickness [1] by which another normal must beat that of a face."""


@kernel
def meet_convex(
    t: Solids, a: int, b: int, margin: float, _least: float, simplex: Simplex, out: Points, row: int
) -> tuple[int, Vec]:  # fmt: skip
    """The contact of two convex shapes, or of a plane and one. Args: as of `answer_pairs`."""
    if t.shape_kind[a, at.TYPE] == at.PLANE:
        return plane_contact(t, a, b, margin, out, row)
    slack = HANDICAP * min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b))
    return convex_contact(t, a, b, margin, slack, simplex, out, row)


@template
def answer_pairs(floats: Floats, ints: Ints, meet: Callable[..., tuple[int, Vec]]) -> None:
    """Answer the pairs of the coming step that have no closed form, for `build_manifolds` to read.

    Args: meet: (shapes, a, b, how far apart [m] they may be, margin of the world [m], scratch, points, row) -> points, normal.
    """
    t, rules, pairs, simplex = solids_of(floats, ints), rules_of(floats, ints), pairs_of(floats, ints), simplex_of(floats, ints)
    out = Points(pairs.point, pairs.point_key, floats_of(floats, ints, at.POLYGON), ints_of(ints, at.POLYGON_KEY))
    state, setting, count = floats_of(floats, ints, at.STATE), rules.setting, rules.numbers
    for p in range(count[0, at.PAIRS]):
        a, b = ordered(t.shape_kind, pairs.pair[p, 0], pairs.pair[p, 1])
        if is_convex_pair(t.shape_kind[a, at.TYPE], t.shape_kind[b, at.TYPE]):
            margin = look_ahead(state, t.shape, t.shape_kind, a, b, setting, count[0, at.CONTINUOUS])
            pairs.points[p, 0], n = meet(t, a, b, margin, setting[0, at.MARGIN], simplex, out, 4 * p)
            store3(pairs.normal, p, 0, n)
    count[0, at.CONVEX_READY] = 1


@entry
def collide_convex(floats: Floats, ints: Ints) -> None:
    """As `answer_pairs`, where triangles are what convex shapes touch."""
    answer_pairs(floats, ints, meet_convex)
