"""Build this step's manifolds from the pairs, and carry the impulses of matching points over from the last step.

Points match when shapes and feature are the same, or, where a corner has just crossed an edge and so changed its feature, when
they lie close together.

Source: Ericson, Real-Time Collision Detection, section 12.4 (features); Catto, Iterative Dynamics with Temporal Coherence,
GDC 2005.
"""

import math

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints, add, axpy, cross, dot, load3, norm, store3, sub
from engine.memory.arena import (
    ARM_A,
    BALL_RADIUS,
    BODY_A,
    BODY_B,
    BOX,
    CONTINUOUS,
    CYLINDER,
    FIRST_GAP,
    HULL,
    LAW,
    LEADS,
    MANIFOLDS,
    MARGIN,
    MATERIAL,
    MATERIALS,
    NEW,
    NORMAL,
    NORMAL_IMPULSE,
    OFF,
    OFFSET,
    OLD_MANIFOLDS,
    OWNER,
    PLACE,
    POINTS,
    SEPARATION,
    SHAPE_A,
    SHAPE_B,
    SIZE,
    SLIPS,
    SPHERE,
    SPIN_IMPULSE,
    STILL,
    SUM,
    SWEPT,
    TANGENT_IMPULSE,
    TOUCHED,
    TRIANGLE,
    TYPE,
    WHOLE_STEP,
    P,
    V,
    W,
)  # fmt: skip
from engine.memory.tables import Bodies, Contacts, Shapes
from engine.narrow.box_box import FACE_OF_B
from engine.narrow.collide import collide, is_convex_pair
from engine.respond.prepare import prepare
from engine.swept.begin import begins

__all__ = ["CORNERS_OF_B", "build_manifolds", "keep_old", "look_ahead", "ordered", "start_anew", "thinnest"]

CORNERS_OF_B = 1 << 24
"""Features of convex pairs from here belong to corners of B on a face of A."""
NEAR = 0.02
"""Share of half the thickness of the thinner shape [1] within which points of different features match."""
AT_REST = 1e-6
"""Tangential speed [m/s] below which a new contact counts as sticking."""


@kernel
def keep_old(
    count: Ints, body_kind: Ints, manifold: Floats, manifold_key: Ints, point: Floats, point_key: Ints, old: Floats,
    old_key: Ints, old_point: Floats, old_point_key: Ints, head: Ints, following: Ints, shapes: int,
) -> None:  # fmt: skip
    """Move the last step's manifolds aside and list them by their first shape; those of still bodies whole."""
    n = count[0, MANIFOLDS]
    count[0, OLD_MANIFOLDS] = n
    for s in range(shapes):
        head[s, 0] = -1
    for m in range(n):
        for c in range(old.shape[1]):
            old[m, c] = manifold[m, c]
        for c in range(old_key.shape[1]):
            old_key[m, c] = manifold_key[m, c]
        still = body_kind[manifold_key[m, BODY_A], STILL] == 1 and body_kind[manifold_key[m, BODY_B], STILL] == 1
        for at in range(4 * m, 4 * m + manifold_key[m, POINTS]):
            for c in range(0 if still else NORMAL_IMPULSE, old_point.shape[1] if still else TANGENT_IMPULSE + 3):
                old_point[at, c] = point[at, c]
            store3(old_point, at, PLACE, load3(point, at, PLACE))
            old_point_key[at, 0] = point_key[at, 0]
        s = manifold_key[m, SHAPE_A]
        following[m, 0] = head[s, 0]
        head[s, 0] = m


@kernel
def thinnest(shape: Floats, shape_kind: Ints, s: int) -> float:
    """Half the smallest width of a shape [m]; inf for planes and triangles, which bound a solid."""
    if shape_kind[s, TYPE] == CYLINDER:
        return float(min(shape[s, SIZE], shape[s, SIZE + 1]))
    if shape_kind[s, TYPE] == BOX or shape_kind[s, TYPE] == HULL:
        return float(min(min(shape[s, SIZE], shape[s, SIZE + 1]), shape[s, SIZE + 2]))
    if shape_kind[s, TYPE] == TRIANGLE:
        return math.inf
    return float(shape[s, SIZE]) if shape[s, BALL_RADIUS] < math.inf else math.inf


@kernel
def ordered(shape_kind: Ints, one: int, two: int) -> tuple[int, int]:
    """Two shapes, that of the lower type first."""
    return (two, one) if shape_kind[one, TYPE] > shape_kind[two, TYPE] else (one, two)


@kernel
def look_ahead(state: Floats, shape: Floats, shape_kind: Ints, a: int, b: int, setting: Floats, continuous: int) -> float:
    """How far apart [m] two shapes may be and still be given a contact for this step: the way they may go towards each other.

    Without continuous collision it ends at half the thickness of the thinner shape, so that a fast body passes a thin wall. A
    swept step that goes on in parts looks as far ahead as the whole of it, so that a pair stays fast or slow.
    """
    i, j = shape_kind[a, OWNER], shape_kind[b, OWNER]
    dt = setting[0, WHOLE_STEP]
    speed = norm(sub(load3(state, j, V), load3(state, i, V)))
    for s, owner in ((a, i), (b, j)):
        if shape[s, BALL_RADIUS] < math.inf:
            # Turning does not move the surface of a ball, but for its centre.
            swing = norm(load3(shape, s, OFFSET)) + (shape[s, BALL_RADIUS] if shape_kind[s, TYPE] != SPHERE else 0.0)
            speed += norm(load3(state, owner, W)) * swing
    way = setting[0, MARGIN] + dt * (speed + dt * norm(load3(setting, 0, 1)))
    if continuous == OFF:
        way = min(way, max(setting[0, MARGIN], 0.5 * min(thinnest(shape, shape_kind, a), thinnest(shape, shape_kind, b))))
    return float(way)


@kernel
def matching_point(point: Floats, key: Ints, i: int, old: Floats, old_key: Ints, first: int, count: int, near: float) -> int:
    """The row of the old point with the feature of point i, else of the closest one within `near` [m], else -1."""
    best, closest = -1, near
    for other in range(first, first + count):
        if old_key[other, 0] == key[i, 0]:
            return other
        apart = norm(sub(load3(old, other, PLACE), load3(point, i, PLACE)))
        if apart < closest:
            best, closest = other, apart
    return best


@kernel
def take_over(
    found: int, manifold: Floats, manifold_key: Ints, point: Floats, point_key: Ints, m: int, old: Floats, old_key: Ints,
    old_point: Floats, old_point_key: Ints,
) -> None:  # fmt: skip
    """Take an old manifold over as it was, into row `found`."""
    for c in range(old.shape[1]):
        manifold[found, c] = old[m, c]
    for c in range(old_key.shape[1]):
        manifold_key[found, c] = old_key[m, c]
    for k in range(old_key[m, POINTS]):
        for c in range(old_point.shape[1]):
            point[4 * found + k, c] = old_point[4 * m + k, c]
        point_key[4 * found + k, 0] = old_point_key[4 * m + k, 0]


@kernel
def start_anew(state: Floats, first: int, end: int, key: Ints, point: Floats) -> None:
    """Begin a step with the manifolds first..end - 1 as they are; `refresh` has put their points where the bodies are now."""
    for m in range(first, end):
        pa = load3(state, key[m, BODY_A], P)
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            point[i, FIRST_GAP] = point[i, SEPARATION]
            store3(point, i, PLACE, add(pa, load3(point, i, ARM_A)))
            store3(point, i, SUM, (0.0, 0.0, 0.0))


@kernel
def build_manifolds(
    bodies: Bodies, shape: Floats, shape_kind: Ints, pose: Floats,
    surface: Floats, setting: Floats, count: Ints, pair: Ints, pairs: int, manifold: Floats, manifold_key: Ints, point: Floats,
    point_key: Ints, old: Floats, old_key: Ints, old_point: Floats, old_point_key: Ints, head: Ints, following: Ints,
    clip: Floats, clip_key: Ints, convex_normal: Floats, convex_point: Floats, convex_key: Ints, convex_point_key: Ints,
) -> None:  # fmt: skip
    """Run the narrow phase on all pairs, match the points found with the old ones, and prepare them.

    Manifolds between still bodies stay what they were.
    """
    state, body_kind = bodies.state, bodies.kind
    shapes, contacts = Shapes(shape, pose, shape_kind), Contacts(manifold, point, manifold_key, point_key)
    found, new = 0, 0
    for p in range(pairs):
        a, b = ordered(shape_kind, pair[p, 0], pair[p, 1])
        i, j = shape_kind[a, OWNER], shape_kind[b, OWNER]
        m = head[a, 0]
        while m >= 0 and old_key[m, SHAPE_B] != b:
            m = following[m, 0]
        if m >= 0 and body_kind[i, STILL] == 1 and body_kind[j, STILL] == 1:
            take_over(found, manifold, manifold_key, point, point_key, m, old, old_key, old_point, old_point_key)
            start_anew(state, found, found + 1, manifold_key, point)
            body_kind[i, TOUCHED] = 1
            body_kind[j, TOUCHED] = 1
            found += 1
            continue
        margin = look_ahead(state, shape, shape_kind, a, b, setting, count[0, CONTINUOUS])
        at = 4 * found
        if is_convex_pair(shape_kind[a, TYPE], shape_kind[b, TYPE]):
            points, normal = convex_key[p, 0], load3(convex_normal, p, 0)
            for k in range(points):
                store3(point, at + k, PLACE, load3(convex_point, 4 * p + k, PLACE))
                point[at + k, FIRST_GAP], point_key[at + k, 0] = (
                    convex_point[4 * p + k, FIRST_GAP],
                    convex_point_key[4 * p + k, 0],
                )
        else:
            points, normal = collide(shape, shape_kind, pose, a, b, margin, point, point_key, at, clip, clip_key)
        if points <= 0:
            continue
        if count[0, CONTINUOUS] == SWEPT and not begins(state, setting, i, j, normal, point, at, points, margin):
            continue
        for k in range(points):
            for c in range(point.shape[1]):
                if c != FIRST_GAP and not PLACE <= c < PLACE + 3:
                    point[at + k, c] = 0.0
        for c in range(manifold.shape[1]):
            manifold[found, c] = 0.0
        store3(manifold, found, NORMAL, normal)
        law = shape_kind[a, MATERIAL] * count[0, MATERIALS] + shape_kind[b, MATERIAL]
        for c in range(5):
            manifold[found, LAW + c] = surface[law, c]
        manifold_key[found, SHAPE_A], manifold_key[found, SHAPE_B] = a, b
        manifold_key[found, BODY_A], manifold_key[found, BODY_B] = i, j
        manifold_key[found, POINTS], manifold_key[found, SLIPS] = points, 0
        corners_of_b = shape_kind[a, TYPE] == BOX and shape_kind[b, TYPE] == BOX and point_key[at, 0] < FACE_OF_B
        manifold_key[found, LEADS] = 1 if corners_of_b or point_key[at, 0] >= CORNERS_OF_B else 0
        body_kind[i, TOUCHED] = 1
        body_kind[j, TOUCHED] = 1
        if m < 0:
            new += 1
            place = load3(point, at, PLACE)
            va = add(load3(state, i, V), cross(load3(state, i, W), sub(place, load3(state, i, P))))
            vb = add(load3(state, j, V), cross(load3(state, j, W), sub(place, load3(state, j, P))))
            u = sub(vb, va)
            manifold_key[found, SLIPS] = 1 if norm(axpy(-dot(u, normal), normal, u)) > AT_REST else 0
        else:
            manifold_key[found, SLIPS] = old_key[m, SLIPS]
            store3(manifold, found, SPIN_IMPULSE, load3(old, m, SPIN_IMPULSE))
            near = NEAR * min(thinnest(shape, shape_kind, a), thinnest(shape, shape_kind, b))
            for k in range(points):
                twin = matching_point(point, point_key, at + k, old_point, old_point_key, 4 * m, old_key[m, POINTS], near)
                if twin >= 0:
                    point[at + k, NORMAL_IMPULSE] = old_point[twin, NORMAL_IMPULSE]
                    store3(point, at + k, TANGENT_IMPULSE, load3(old_point, twin, TANGENT_IMPULSE))
        prepare(bodies, shapes, contacts, found)
        found += 1
    count[0, MANIFOLDS], count[0, NEW] = found, new
