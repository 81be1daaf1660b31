"""Contacts of worlds of spheres: one point per pair, in the order of the pairs, matched with the last step's by walking both.

Source: Ericson, Real-Time Collision Detection, section 4.3.1; Catto, Iterative Dynamics with Temporal Coherence, GDC 2005.
"""

from engine.broad.bounds import brute_force, place_shapes
from engine.broad.collision_filter import collision_filter_of
from engine.compile.jit import kernel
from engine.contact.look_ahead import look_ahead
from engine.contact.manifolds import AT_REST
from engine.maths.vec import Floats, Ints, Vec, add, axpy, cross, dot, load3, norm, scale, store3, sub
from engine.memory.arena import (
    BODIES,
    BODY,
    BODY_KIND,
    BOUNDS,
    BOX,
    BROAD,
    CLIP,
    CLIP_KEY,
    COLOURED,
    CONTINUOUS,
    COUNT,
    DT,
    DYNAMIC,
    FIRST_GAP,
    FOLLOWING,
    GRAVITY,
    INV_INERTIA,
    INV_MASS,
    K_BODY_A,
    K_BODY_B,
    K_MOVES,
    K_PAIR,
    K_ROUND,
    K_SLIPS,
    LAST_OF_SPHERE,
    M_INV_INERTIA,
    M_INV_MASS,
    MANIFOLDS,
    MARGIN,
    MATERIAL,
    MATERIALS,
    MOTION,
    MOVER,
    NEW,
    OLD_TOUCH,
    OLD_TOUCH_KEY,
    OWNER,
    PAIR,
    PAIRS,
    PLACE,
    POINT,
    POINT_KEY,
    POSE,
    R_FIRST_GAP,
    R_KINETIC,
    R_NORMAL,
    R_PLACE,
    R_RESTITUTION,
    R_SPIKE,
    R_STATIC,
    R_STRUCK,
    SETTING,
    SHAPES,
    SIZE,
    SPECULATIVE,
    SPHERE,
    STATE,
    SURFACE,
    T_BASE,
    T_FRICTION,
    T_GAP,
    T_NORMAL,
    T_NORMAL_MASS,
    T_RADIUS_A,
    T_RADIUS_B,
    T_SUM,
    T_TANGENT,
    T_TANGENT_MASS,
    TOUCH,
    TOUCH_KEY,
    TOUCH_REST,
    TOUCHED,
    TYPE,
    V,
    W,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DONE, FULL
from engine.memory.tables import Shapes, shapes_of
from engine.narrow.box_pairs import sphere_box
from engine.narrow.point import Points
from engine.narrow.round_pairs import sphere_plane
from engine.narrow.solid import solid_of

__all__ = ["find_touches"]


@kernel
def against_static(shapes: Shapes, a: int, b: int, margin: float, out: Points) -> tuple[int, Vec]:
    """Sphere a against box or plane b, written on row 0 of `out`. Returns: points, normal."""
    one, two = solid_of(shapes, a), solid_of(shapes, b)
    if shapes.kind[b, TYPE] == BOX:
        return sphere_box(one, two, margin, out, 0)
    return sphere_plane(one, two, margin, out, 0)


@kernel
def gather(floats: Floats, ints: Ints) -> None:
    """Copy what the solver needs of each body into one row, and mark all bodies as untouched."""
    state, body, mover = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, MOVER)
    kind = ints_of(ints, BODY_KIND)
    for b in range(ints_of(ints, COUNT)[0, BODIES] + 1):
        kind[b, TOUCHED] = 0
        store3(mover, b, 0, load3(state, b, V))
        store3(mover, b, 3, load3(state, b, W))
        mover[b, M_INV_MASS], mover[b, M_INV_INERTIA] = body[b, INV_MASS], body[b, INV_INERTIA]


@kernel
def keep_old(touch: Floats, key: Ints, first: int, last: int, old: Floats, old_key: Ints) -> None:
    """Copy what the next step takes over of a range of contacts, before others are written in their place."""
    for m in range(first, last):
        old_key[m, 0], old_key[m, 1] = key[m, K_PAIR], key[m, K_SLIPS]
        for c in range(4):
            old[m, c] = touch[m, T_NORMAL + c]


@kernel
def list_by_sphere(key: Ints, first: int, last: int, head: Ints, table: Ints) -> None:
    """List the contacts of the last step in a range of rows by their sphere A. Args: head: LAST_OF_SPHERE; table: COLOURED."""
    for b in range(head.shape[0]):
        head[b, 0] = -1
    for m in range(first, last):
        table[m, FOLLOWING] = head[key[m, K_BODY_A], 0]
        head[key[m, K_BODY_A], 0] = m


@kernel
def build_touches(floats: Floats, ints: Ints, pairs: int) -> None:
    """Run the narrow phase on all pairs and take over the impulses of those that touched in the last step.

    Up to the first pair that did not, or that does no longer, contacts stay in their rows with all that never changes. Pairs
    come in rising order, and both steps' contacts are walked at once; where colours sort them otherwise, those of the last step
    are looked up by their sphere.
    """
    tables, surface = shapes_of(floats, ints), floats_of(floats, ints, SURFACE)
    shape, pose, shape_kind = tables
    touch, rest, old = floats_of(floats, ints, TOUCH), floats_of(floats, ints, TOUCH_REST), floats_of(floats, ints, OLD_TOUCH)
    state, mover, setting = floats_of(floats, ints, STATE), floats_of(floats, ints, MOVER), floats_of(floats, ints, SETTING)
    points = Points(
        floats_of(floats, ints, POINT), ints_of(ints, POINT_KEY), floats_of(floats, ints, CLIP), ints_of(ints, CLIP_KEY)
    )  # fmt: skip
    key, old_key, pair = ints_of(ints, TOUCH_KEY), ints_of(ints, OLD_TOUCH_KEY), ints_of(ints, PAIR)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    last, shapes, materials, continuous = count[0, MANIFOLDS], count[0, SHAPES], count[0, MATERIALS], count[0, CONTINUOUS]
    head, table = ints_of(ints, LAST_OF_SPHERE), ints_of(ints, COLOURED)
    least, dt, coloured = setting[0, MARGIN], setting[0, DT], head.shape[0] > 0
    fall = dt * norm(load3(setting, 0, GRAVITY))
    found, new, walk, as_before = 0, 0, 0, True
    for p in range(pairs):
        code = pair[p, 0] * shapes + pair[p, 1]
        a, b = pair[p, 0], pair[p, 1]
        if shape_kind[a, TYPE] != SPHERE or kind[shape_kind[a, OWNER], MOTION] != DYNAMIC:
            a, b = b, a
        i, j, t = shape_kind[a, OWNER], shape_kind[b, OWNER], found
        pa, ra = load3(pose, a, 0), shape[a, SIZE]
        # Spheres are compared here: a call that hands over several arrays costs more than the comparison.
        if shape_kind[b, TYPE] == SPHERE:
            is_round, rb, d = 1, shape[b, SIZE], sub(load3(pose, b, 0), pa)
            length = norm(d)
            gap = length - ra - rb
            if gap > least:
                way = least + dt * (norm(sub(load3(mover, j, 0), load3(mover, i, 0))) + fall)
                if gap > (way if continuous == SPECULATIVE else min(way, max(least, min(ra, rb)))):
                    continue
            n = scale(1.0 / length, d) if length > 1e-300 else (0.0, 0.0, 1.0)
            place = axpy(ra + 0.5 * gap, n, pa)
        else:
            is_round, rb = 0, 0.0
            margin = look_ahead(state, shape, shape_kind, a, b, setting, continuous)
            touching, n = against_static(tables, a, b, margin, points)
            if touching == 0:
                continue
            gap, place = points.point[0, FIRST_GAP], load3(points.point, 0, PLACE)
        la, lb = ra + 0.5 * gap, rb + 0.5 * gap
        mass = mover[i, M_INV_MASS] + mover[j, M_INV_MASS]
        if as_before and (t >= last or key[t, K_PAIR] != code):
            as_before, walk = False, t
            keep_old(touch, key, t, last, old, old_key)
            if coloured:
                list_by_sphere(key, t, last, head, table)
        store3(touch, t, 0, n)
        touch[t, T_GAP] = gap
        touch[t, T_TANGENT_MASS] = 1.0 / (mass + la * la * mover[i, M_INV_INERTIA] + lb * lb * mover[j, M_INV_INERTIA])
        touch[t, T_BASE] = gap + dot(n, pa)
        store3(touch, t, T_SUM, (0.0, 0.0, 0.0))
        store3(rest, t, R_PLACE, place)
        store3(rest, t, R_NORMAL, n)
        rest[t, R_FIRST_GAP] = gap
        kind[i, TOUCHED] = 1
        kind[j, TOUCHED] = 1
        found += 1
        if as_before:
            held = load3(touch, t, T_TANGENT)
            store3(touch, t, T_TANGENT, axpy(-dot(n, held), n, held))
            continue
        touch[t, T_NORMAL_MASS] = 1.0 / mass
        touch[t, T_RADIUS_A], touch[t, T_RADIUS_B] = ra, rb
        law = shape_kind[a, MATERIAL] * materials + shape_kind[b, MATERIAL]
        rest[t, R_STATIC], rest[t, R_KINETIC], rest[t, R_RESTITUTION] = surface[law, 0], surface[law, 1], surface[law, 2]
        rest[t, R_STRUCK], rest[t, R_SPIKE] = 0.0, 0.0
        key[t, K_BODY_A], key[t, K_BODY_B], key[t, K_PAIR], key[t, K_ROUND] = i, j, code, is_round
        key[t, K_MOVES] = 1 if kind[j, MOTION] == DYNAMIC else 0
        if coloured:
            walk = head[i, 0]
            while walk >= 0 and old_key[walk, 0] != code:
                walk = table[walk, FOLLOWING]
            walk = walk if walk >= 0 else last
        else:
            while walk < last and old_key[walk, 0] < code:
                walk += 1
        if walk < last and old_key[walk, 0] == code:
            key[t, K_SLIPS], touch[t, T_NORMAL] = old_key[walk, 1], old[walk, 0]
            held = load3(old, walk, 1)
            store3(touch, t, T_TANGENT, axpy(-dot(n, held), n, held))
        else:
            new += 1
            spin = add(scale(la, load3(mover, i, 3)), scale(lb, load3(mover, j, 3)))
            u = sub(sub(load3(mover, j, 0), load3(mover, i, 0)), cross(spin, n))
            key[t, K_SLIPS] = 1 if norm(axpy(-dot(u, n), n, u)) > AT_REST else 0
            touch[t, T_NORMAL] = 0.0
            store3(touch, t, T_TANGENT, (0.0, 0.0, 0.0))
        touch[t, T_FRICTION] = rest[t, R_STATIC] if key[t, K_SLIPS] == 0 else rest[t, R_KINETIC]
    count[0, MANIFOLDS], count[0, NEW] = found, new


@kernel
def find_touches(floats: Floats, ints: Ints) -> int:
    """Find the contacts of this step and mark the bodies they touch. Returns: DONE, or FULL."""
    pose, bounds = floats_of(floats, ints, POSE), floats_of(floats, ints, BOUNDS)
    pair, count = ints_of(ints, PAIR), ints_of(ints, COUNT)
    if count[0, BROAD] == 0:
        place_shapes(floats, ints)
        count[0, PAIRS] = brute_force(collision_filter_of(floats, ints), bounds, pose, count[0, SHAPES], pair)
        if count[0, PAIRS] > pair.shape[0]:
            return FULL
    gather(floats, ints)
    build_touches(floats, ints, count[0, PAIRS])
    return DONE
