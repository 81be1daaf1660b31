"""Build this step's manifolds from the pairs, and carry the impulses of matching points over from the last step.

Points match when shapes and feature are the same, or, where a corner has just crossed an edge and so changed its feature, when
they lie close together.

Source: Ericson, Real-Time Collision Detection, section 12.4 (features); Catto, Iterative Dynamics with Temporal Coherence,
GDC 2005.
"""

import math

from engine.compile.jit import kernel
from engine.contact.tables import OldContacts, Pairs, Rules
from engine.maths.vec import Floats, Ints, Vec, add, axpy, cross, dot, load3, norm, store3, sub
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
    PAIRS,
    PLACE,
    POINTS,
    SEPARATION,
    SHAPE_A,
    SHAPE_B,
    SHAPES,
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
from engine.memory.tables import Bodies, Contacts
from engine.narrow.box_box import FACE_OF_B
from engine.narrow.collide import collide, is_convex_pair
from engine.narrow.point import CORNERS_OF_B, Points
from engine.narrow.support import Solids
from engine.respond.soft import prepare
from engine.swept.begin import FAST, begins

__all__ = ["build_manifolds", "keep_old", "look_ahead", "ordered", "start_anew", "thinnest"]

NEAR = 0.02
"""Share of half the thickness of the thinner shape [1] within which points of different features match."""
AT_REST = 1e-6
"""Tangential speed [m/s] below which a new contact counts as sticking."""


@kernel
def keep_old(kind: Ints, count: Ints, new: Contacts, old: OldContacts) -> None:
    """Move the last step's manifolds aside and list them by their first shape; those of still bodies whole."""
    n = count[0, MANIFOLDS]
    count[0, OLD_MANIFOLDS] = n
    for s in range(count[0, SHAPES]):
        old.head[s, 0] = -1
    for m in range(n):
        for c in range(old.manifold.shape[1]):
            old.manifold[m, c] = new.manifold[m, c]
        for c in range(old.key.shape[1]):
            old.key[m, c] = new.key[m, c]
        still = kind[new.key[m, BODY_A], STILL] == 1 and kind[new.key[m, BODY_B], STILL] == 1
        for at in range(4 * m, 4 * m + new.key[m, POINTS]):
            for c in range(0 if still else NORMAL_IMPULSE, old.point.shape[1] if still else TANGENT_IMPULSE + 3):
                old.point[at, c] = new.point[at, c]
            store3(old.point, at, PLACE, load3(new.point, at, PLACE))
            old.point_key[at, 0] = new.point_key[at, 0]
        s = new.key[m, SHAPE_A]
        old.following[m, 0] = old.head[s, 0]
        old.head[s, 0] = m


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
def last_manifold(old: OldContacts, a: int, b: int) -> int:
    """The row of the manifold that shapes a and b had in the last step, or -1."""
    m = old.head[a, 0]
    while m >= 0 and old.key[m, SHAPE_B] != b:
        m = old.following[m, 0]
    return int(m)


@kernel
def matching_point(new: Contacts, i: int, old: OldContacts, m: int, near: float) -> int:
    """The row of the point of old manifold m with the feature of point i, else of the closest within `near` [m], else -1."""
    best, closest = -1, near
    for other in range(4 * m, 4 * m + old.key[m, POINTS]):
        if old.point_key[other, 0] == new.point_key[i, 0]:
            return other
        apart = norm(sub(load3(old.point, other, PLACE), load3(new.point, i, PLACE)))
        if apart < closest:
            best, closest = other, apart
    return best


@kernel
def take_over(new: Contacts, row: int, old: OldContacts, m: int) -> None:
    """Take old manifold m over as it was."""
    for c in range(old.manifold.shape[1]):
        new.manifold[row, c] = old.manifold[m, c]
    for c in range(old.key.shape[1]):
        new.key[row, c] = old.key[m, c]
    for k in range(old.key[m, POINTS]):
        for c in range(old.point.shape[1]):
            new.point[4 * row + k, c] = old.point[4 * m + k, c]
        new.point_key[4 * row + k, 0] = old.point_key[4 * m + k, 0]


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
def find_points(t: Solids, pairs: Pairs, p: int, a: int, b: int, margin: float, out: Points, at: int) -> tuple[int, Vec]:
    """Write the contact points of pair p, shapes a and b, from row `at` on: as answered, or by their closed form.

    Returns: as `collide`.
    """
    if not is_convex_pair(t.shape_kind[a, TYPE], t.shape_kind[b, TYPE]):
        return collide(t, a, b, margin, out, at)
    points = pairs.points[p, 0]
    for k in range(points):
        store3(out.point, at + k, PLACE, load3(pairs.point, 4 * p + k, PLACE))
        out.point[at + k, FIRST_GAP], out.key[at + k, 0] = pairs.point[4 * p + k, FIRST_GAP], pairs.point_key[4 * p + k, 0]
    return points, load3(pairs.normal, p, 0)


@kernel
def begin_manifold(t: Solids, rules: Rules, a: int, b: int, points: int, normal: Vec, new: Contacts, row: int) -> None:
    """Write what the narrow phase found of shapes a and b into a row, and clear the rest of it and of its points."""
    at = 4 * row
    for k in range(points):
        for c in range(new.point.shape[1]):
            if c != FIRST_GAP and not PLACE <= c < PLACE + 3:
                new.point[at + k, c] = 0.0
    for c in range(new.manifold.shape[1]):
        new.manifold[row, c] = 0.0
    store3(new.manifold, row, NORMAL, normal)
    law = t.shape_kind[a, MATERIAL] * rules.numbers[0, MATERIALS] + t.shape_kind[b, MATERIAL]
    for c in range(5):
        new.manifold[row, LAW + c] = rules.surface[law, c]
    new.key[row, SHAPE_A], new.key[row, SHAPE_B] = a, b
    new.key[row, BODY_A], new.key[row, BODY_B] = t.shape_kind[a, OWNER], t.shape_kind[b, OWNER]
    new.key[row, POINTS], new.key[row, SLIPS] = points, 0
    corners_of_b = t.shape_kind[a, TYPE] == BOX and t.shape_kind[b, TYPE] == BOX and new.point_key[at, 0] < FACE_OF_B
    new.key[row, LEADS] = 1 if corners_of_b or new.point_key[at, 0] >= CORNERS_OF_B else 0


@kernel
def start_slip(state: Floats, new: Contacts, row: int) -> None:
    """Let a new manifold slip or stick by the velocity of its first point."""
    i, j, n = new.key[row, BODY_A], new.key[row, BODY_B], load3(new.manifold, row, NORMAL)
    x = load3(new.point, 4 * row, PLACE)
    va = add(load3(state, i, V), cross(load3(state, i, W), sub(x, load3(state, i, P))))
    vb = add(load3(state, j, V), cross(load3(state, j, W), sub(x, load3(state, j, P))))
    u = sub(vb, va)
    new.key[row, SLIPS] = 1 if norm(axpy(-dot(u, n), n, u)) > AT_REST else 0


@kernel
def carry_over(new: Contacts, row: int, old: OldContacts, m: int, near: float) -> None:
    """Start a manifold with the impulses of old manifold m, point by point; points within `near` [m] match."""
    new.key[row, SLIPS] = old.key[m, SLIPS]
    store3(new.manifold, row, SPIN_IMPULSE, load3(old.manifold, m, SPIN_IMPULSE))
    for i in range(4 * row, 4 * row + new.key[row, POINTS]):
        twin = matching_point(new, i, old, m, near)
        if twin >= 0:
            new.point[i, NORMAL_IMPULSE] = old.point[twin, NORMAL_IMPULSE]
            store3(new.point, i, TANGENT_IMPULSE, load3(old.point, twin, TANGENT_IMPULSE))


@kernel
def build_manifolds(
    bodies: Bodies, t: Solids, rules: Rules, pairs: Pairs, new: Contacts, old: OldContacts, out: Points
) -> None:  # fmt: skip
    """Run the narrow phase on all pairs, match the points found with the old ones, and prepare them.

    Manifolds between still bodies stay what they were.

    Args: out: the points of the new contacts, and scratch.
    """
    state, kind, setting, count = bodies.state, bodies.kind, rules.setting, rules.numbers
    row, fresh = 0, 0
    for p in range(count[0, PAIRS]):
        a, b = ordered(t.shape_kind, pairs.pair[p, 0], pairs.pair[p, 1])
        i, j, m = t.shape_kind[a, OWNER], t.shape_kind[b, OWNER], last_manifold(old, a, b)
        if m >= 0 and kind[i, STILL] == 1 and kind[j, STILL] == 1:
            take_over(new, row, old, m)
            start_anew(state, row, row + 1, new.key, new.point)
            kind[i, TOUCHED] = 1
            kind[j, TOUCHED] = 1
            row += 1
            continue
        margin = look_ahead(state, t.shape, t.shape_kind, a, b, setting, count[0, CONTINUOUS])
        points, normal = find_points(t, pairs, p, a, b, margin, out, 4 * row)
        if points <= 0:
            continue
        fast = count[0, CONTINUOUS] == SWEPT and not margin <= FAST * setting[0, MARGIN]
        if fast and not begins(state, setting, i, j, normal, new.point, 4 * row, points):
            continue
        begin_manifold(t, rules, a, b, points, normal, new, row)
        kind[i, TOUCHED] = 1
        kind[j, TOUCHED] = 1
        if m < 0:
            fresh += 1
            start_slip(state, new, row)
        else:
            carry_over(new, row, old, m, NEAR * min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b)))
        prepare(state, bodies.body, bodies.turned, t.shape, t.shape_kind, t.pose, row, new.manifold, new.key, new.point)
        row += 1
    count[0, MANIFOLDS], count[0, NEW] = row, fresh
