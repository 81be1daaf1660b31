"""The convex narrow phase of one step, compiled only where two shapes without a closed form come near each other."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.contact.look_ahead import look_ahead, thinnest
from plumbline.engine.contact.tables import pairs_of, rules_of
from plumbline.engine.maths.rows import Floats, Ints, store3
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.narrow.collide import is_convex_pair, ordered
from plumbline.engine.narrow.convex import convex_contact, plane_contact
from plumbline.engine.narrow.gjk import simplex_of
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.support import solids_of

HANDICAP = 1e-3
"""Share of the thinner shape's half thickness [1] by which another normal must beat that of a face."""


@entry
def collide_convex(floats: Floats, ints: Ints) -> None:
    """Answer the pairs of the coming step that have no closed form, for `build_manifolds` to read."""
    t, rules, pairs, simplex = solids_of(floats, ints), rules_of(floats, ints), pairs_of(floats, ints), simplex_of(floats, ints)
    out = Points(pairs.point, pairs.point_key, floats_of(floats, ints, at.POLYGON), ints_of(ints, at.POLYGON_KEY))
    state, setting, count = floats_of(floats, ints, at.STATE), rules.setting, rules.numbers
    for p in range(count[0, at.PAIRS]):
        a, b = ordered(t.shape_kind, pairs.pair[p, 0], pairs.pair[p, 1])
        if not is_convex_pair(t.shape_kind[a, at.TYPE], t.shape_kind[b, at.TYPE]):
            continue
        margin = look_ahead(state, t.shape, t.shape_kind, a, b, setting, count[0, at.CONTINUOUS])
        if t.shape_kind[a, at.TYPE] == at.PLANE:
            points, n = plane_contact(t, a, b, margin, out, 4 * p)
        else:
            slack = HANDICAP * min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b))
            points, n = convex_contact(t, a, b, margin, slack, simplex, out, 4 * p)
        pairs.points[p, 0] = points
        store3(pairs.normal, p, 0, n)
    count[0, at.CONVEX_READY] = 1
