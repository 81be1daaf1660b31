"""The collision stages of a step, in order: poses, bounds, broad phase unless done, narrow phase with matching, preparation.

Where every body is still, a step may keep the contacts of the last one and run none of this.
"""

from engine.broad.bounds import brute_force, pose_shapes, write_bounds
from engine.compile.jit import kernel
from engine.contact.manifolds import build_manifolds, keep_old, ordered, start_anew
from engine.contact.stillness import keep_rest, mark_still
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    BODY,
    BODY_KIND,
    BOUNDS,
    BROAD,
    CLIP,
    CLIP_KEY,
    CONVEX_KEY,
    CONVEX_NORMAL,
    CONVEX_POINT,
    CONVEX_POINT_KEY,
    CONVEX_READY,
    COUNT,
    DT,
    EXCLUDED,
    EXCLUSIONS,
    HEAD,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MARGIN,
    MATERIALS,
    NEW,
    NEXT,
    OLD_KEY,
    OLD_MANIFOLD,
    OLD_POINT,
    OLD_POINT_KEY,
    PAIR,
    PAIRS,
    POINT,
    POINT_KEY,
    POSE,
    REST,
    SETTING,
    SHAPE,
    SHAPE_KIND,
    SHAPES,
    STATE,
    SURFACE,
    TOUCHED,
    TYPE,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of
from engine.narrow.collide import is_convex_pair

__all__ = ["find_contacts", "keep_contacts"]


@kernel
def keep_contacts(
    state: Floats, body: Floats, kind: Ints, rest: Floats, setting: Floats, count: Ints, key: Ints, point: Floats
) -> bool:
    """Keep the contacts of the last step for this one, where all bodies are still. Returns: whether they are."""
    if not mark_still(state, body, kind, rest, count[0, BODIES], setting[0, DT], setting[0, MARGIN]):
        return False
    start_anew(state, 0, count[0, MANIFOLDS], key, point)
    count[0, NEW] = 0
    return True


@kernel
def find_contacts(floats: Floats, ints: Ints) -> int:
    """Find and prepare the contacts of this step, and mark the bodies they touch.

    Returns: 0, or 2 if the arena has no room for all pairs, or 3 if pairs wait for the convex narrow phase; then nothing has
    changed but the list of pairs.
    """
    state, shape, pose = floats_of(floats, ints, STATE), floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE)
    bounds, setting = floats_of(floats, ints, BOUNDS), floats_of(floats, ints, SETTING)
    body = floats_of(floats, ints, BODY)
    manifold, point = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT)
    kind, shape_kind = ints_of(ints, BODY_KIND), ints_of(ints, SHAPE_KIND)
    excluded, pair = ints_of(ints, EXCLUDED), ints_of(ints, PAIR)
    key, point_key = ints_of(ints, MANIFOLD_KEY), ints_of(ints, POINT_KEY)
    old, old_point = floats_of(floats, ints, OLD_MANIFOLD), floats_of(floats, ints, OLD_POINT)
    old_key, old_point_key = ints_of(ints, OLD_KEY), ints_of(ints, OLD_POINT_KEY)
    head, following, count = ints_of(ints, HEAD), ints_of(ints, NEXT), ints_of(ints, COUNT)
    surface, materials = floats_of(floats, ints, SURFACE), count[0, MATERIALS]
    shapes, exclusions = count[0, SHAPES], count[0, EXCLUSIONS]
    rest, bodies = floats_of(floats, ints, REST), count[0, BODIES]
    mark_still(state, body, kind, rest, bodies, setting[0, DT], setting[0, MARGIN])
    if count[0, BROAD] == 0:
        pose_shapes(state, shape, shape_kind, shapes, pose)
        write_bounds(state, shape, shape_kind, shapes, pose, bounds, setting)
        count[0, PAIRS] = brute_force(bounds, shape_kind, kind, surface, materials, excluded, exclusions, pose, shapes, pair)
    pairs = count[0, PAIRS]
    if pairs > pair.shape[0]:
        return 2
    for p in range(pairs):
        a, b = ordered(shape_kind, pair[p, 0], pair[p, 1])
        if count[0, CONVEX_READY] == 0 and is_convex_pair(shape_kind[a, TYPE], shape_kind[b, TYPE]):
            return 3
    count[0, CONVEX_READY] = 0
    for b in range(bodies + 1):
        kind[b, TOUCHED] = 0
    keep_old(count, kind, manifold, key, point, point_key, old, old_key, old_point, old_point_key, head, following, shapes)
    build_manifolds(
        bodies_of(floats, ints), shape, shape_kind, pose, surface, setting, count, pair, pairs, manifold, key, point,
        point_key, old, old_key, old_point, old_point_key, head, following, floats_of(floats, ints, CLIP), ints_of(ints,
        CLIP_KEY), floats_of(floats, ints, CONVEX_NORMAL), floats_of(floats, ints, CONVEX_POINT), ints_of(ints, CONVEX_KEY),
        ints_of(ints, CONVEX_POINT_KEY),
    )  # fmt: skip
    keep_rest(state, kind, rest, bodies)
    return 0
