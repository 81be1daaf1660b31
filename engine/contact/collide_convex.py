"""The convex narrow phase of one step, compiled only where two shapes without a closed form come near each other."""

from engine.compile.jit import entry, kernel
from engine.contact.manifolds import look_ahead, ordered, thinnest
from engine.maths.vec import Floats, Ints, store3
from engine.memory.arena import (
    CONTINUOUS,
    CONVEX_KEY,
    CONVEX_NORMAL,
    CONVEX_POINT,
    CONVEX_POINT_KEY,
    CONVEX_READY,
    COUNT,
    FACE,
    LOOP,
    PAIR,
    PAIRS,
    PLANE,
    POLYGON,
    POLYGON_KEY,
    POLYHEDRON,
    POSE,
    SETTING,
    SHAPE,
    SHAPE_KIND,
    SIMPLEX,
    SIMPLEX_KEY,
    SPAN,
    STATE,
    TYPE,
    VERTEX,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.narrow.collide import is_convex_pair
from engine.narrow.convex import convex_contact, plane_contact
from engine.narrow.support import Solids

__all__ = ["collide_convex", "solids"]

HANDICAP = 1e-3
"""Share of the thinner shape's half thickness [1] by which another normal must beat that of a face."""


@kernel
def solids(floats: Floats, ints: Ints) -> Solids:
    """The tables of shapes."""
    return Solids(
        floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE), floats_of(floats, ints, VERTEX),
        floats_of(floats, ints, FACE), ints_of(ints, SHAPE_KIND), ints_of(ints, POLYHEDRON), ints_of(ints, SPAN),
        ints_of(ints, LOOP),
    )  # fmt: skip


@entry
def collide_convex(floats: Floats, ints: Ints) -> None:
    """Answer the pairs of the coming step that have no closed form, for `build_manifolds` to read."""
    t = solids(floats, ints)
    state, setting, count, pair = (
        floats_of(floats, ints, STATE),
        floats_of(floats, ints, SETTING),
        ints_of(ints, COUNT),
        ints_of(ints, PAIR),
    )
    normal, point, key = (
        floats_of(floats, ints, CONVEX_NORMAL),
        floats_of(floats, ints, CONVEX_POINT),
        ints_of(ints, CONVEX_KEY),
    )
    point_key, work, work_key = ints_of(ints, CONVEX_POINT_KEY), floats_of(floats, ints, SIMPLEX), ints_of(ints, SIMPLEX_KEY)
    polygon, polygon_key = floats_of(floats, ints, POLYGON), ints_of(ints, POLYGON_KEY)
    for p in range(count[0, PAIRS]):
        a, b = ordered(t.shape_kind, pair[p, 0], pair[p, 1])
        if not is_convex_pair(t.shape_kind[a, TYPE], t.shape_kind[b, TYPE]):
            continue
        margin = look_ahead(state, t.shape, t.shape_kind, a, b, setting, count[0, CONTINUOUS])
        if t.shape_kind[a, TYPE] == PLANE:
            found, n = plane_contact(t, a, b, margin, polygon, polygon_key, point, point_key, 4 * p)
        else:
            slack = HANDICAP * min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b))
            found, n = convex_contact(
                t, a, b, margin, slack, work, work_key, polygon, polygon_key, point, point_key, 4 * p
            )  # fmt: skip
        key[p, 0] = found
        store3(normal, p, 0, n)
    count[0, CONVEX_READY] = 1
