"""Find the pairs of shapes whose bounds overlap: sweep-and-prune along x, or brute force as its oracle.

Source: Ericson, Real-Time Collision Detection, section 7.5 (sort and sweep); Baraff, Dynamic Simulation of Non-Penetrating
Rigid Bodies, 1992, section 2.3.
"""

import math

from engine.arena import (
    APART,
    BALL_RADIUS,
    BOX,
    CAPSULE,
    DYNAMIC,
    HULL,
    MATERIAL,
    MOTION,
    OFFSET,
    OWNER,
    PLANE,
    SIZE,
    SPHERE,
    TURN,
    TYPE,
    P,
    Q,
    V,
    W,
)  # fmt: skip
from engine.jit import kernel
from engine.vec import Floats, Ints, add, load3, load4, load9, mat_vec, norm, quat_mat, quat_mul, store3, store9

__all__ = ["brute_force", "overlap", "pose_shapes", "sweep_and_prune", "write_bounds"]


@kernel
def pose_shapes(state: Floats, shape: Floats, shape_kind: Ints, shapes: int, pose: Floats) -> None:
    """Write position and rotation matrix in W of every shape."""
    for s in range(shapes):
        b = shape_kind[s, OWNER]
        q = load4(state, b, Q)
        store3(pose, s, 0, add(load3(state, b, P), mat_vec(quat_mat(q), load3(shape, s, OFFSET))))
        store9(pose, s, 3, quat_mat(quat_mul(q, load4(shape, s, TURN))))


@kernel
def write_bounds(
    state: Floats, shape: Floats, shape_kind: Ints, shapes: int, pose: Floats, bounds: Floats, margin: float, dt: float
) -> None:
    """Write the axis-aligned bounds [m] of every shape, widened by the margin and by its way in dt."""
    for s in range(shapes):
        kind, b = shape_kind[s, TYPE], shape_kind[s, OWNER]
        grow = margin + dt * norm(load3(state, b, V))
        if shape[s, BALL_RADIUS] < math.inf:
            grow += dt * norm(load3(state, b, W)) * (norm(load3(shape, s, OFFSET)) + shape[s, BALL_RADIUS])
        m = load9(pose, s, 3)
        for k in range(3):
            if kind == PLANE:
                half = math.inf
            elif kind == SPHERE:
                half = shape[s, SIZE]
            elif kind == CAPSULE:
                half = shape[s, SIZE] + shape[s, SIZE + 1] * abs(m[3 * k + 2])
            elif kind == BOX or kind >= HULL:
                half = (
                    shape[s, SIZE] * abs(m[3 * k])
                    + shape[s, SIZE + 1] * abs(m[3 * k + 1])
                    + shape[s, SIZE + 2] * abs(m[3 * k + 2])
                )
            else:
                half = shape[s, BALL_RADIUS]
            bounds[s, k] = pose[s, k] - half - grow
            bounds[s, k + 3] = pose[s, k] + half + grow


@kernel
def overlap(
    bounds: Floats,
    shape_kind: Ints,
    kind: Ints,
    surface: Floats,
    materials: int,
    excluded: Ints,
    exclusions: int,
    pose: Floats,
    i: int,
    j: int,
) -> bool:
    """Whether shapes i and j may touch: bounds overlap, one of them can move, and no joint or material parts them."""
    a, b = shape_kind[i, OWNER], shape_kind[j, OWNER]
    if a == b or (kind[a, MOTION] != DYNAMIC and kind[b, MOTION] != DYNAMIC):
        return False
    if shape_kind[i, TYPE] == PLANE or shape_kind[j, TYPE] == PLANE:
        if shape_kind[i, TYPE] == shape_kind[j, TYPE]:
            return False
        plane, other = (i, j) if shape_kind[i, TYPE] == PLANE else (j, i)
        height = 0.0
        for k in range(3):
            n = pose[plane, 3 + 3 * k + 2]
            lowest = bounds[other, k] if n > 0.0 else bounds[other, k + 3]
            height += n * (lowest - pose[plane, k])
        if height > 0.0:
            return False
    else:
        for k in range(3):
            if bounds[i, k] > bounds[j, k + 3] or bounds[j, k] > bounds[i, k + 3]:
                return False
    if surface[shape_kind[i, MATERIAL] * materials + shape_kind[j, MATERIAL], APART] == 1.0:
        return False
    for e in range(exclusions):
        if (excluded[e, 0] == a and excluded[e, 1] == b) or (excluded[e, 0] == b and excluded[e, 1] == a):
            return False
    return True


@kernel
def brute_force(
    bounds: Floats,
    shape_kind: Ints,
    kind: Ints,
    surface: Floats,
    materials: int,
    excluded: Ints,
    exclusions: int,
    pose: Floats,
    shapes: int,
    pair: Ints,
) -> int:
    """Write every overlapping pair (i < j). Returns: their number, which may exceed the room in `pair`."""
    found = 0
    for i in range(shapes):
        for j in range(i + 1, shapes):
            if overlap(bounds, shape_kind, kind, surface, materials, excluded, exclusions, pose, i, j):
                if found < pair.shape[0]:
                    pair[found, 0], pair[found, 1] = i, j
                found += 1
    return found


@kernel
def sweep_and_prune(
    bounds: Floats, shape_kind: Ints, kind: Ints, surface: Floats, materials: int, excluded: Ints, exclusions: int,
    pose: Floats, shapes: int, order: Ints, pair: Ints
) -> int:  # fmt: skip
    """As `brute_force`, over the shapes sorted by their lower bound in x; the order is kept from step to step."""
    for at in range(1, shapes):
        s = order[at, 0]
        low = bounds[s, 0]
        to = at
        while to > 0 and (bounds[order[to - 1, 0], 0] > low or (bounds[order[to - 1, 0], 0] == low and order[to - 1, 0] > s)):
            order[to, 0] = order[to - 1, 0]
            to -= 1
        order[to, 0] = s
    found = 0
    for at in range(shapes):
        s = order[at, 0]
        high = bounds[s, 3]
        for to in range(at + 1, shapes):
            t = order[to, 0]
            if bounds[t, 0] > high:
                break
            i, j = (s, t) if s < t else (t, s)
            if overlap(bounds, shape_kind, kind, surface, materials, excluded, exclusions, pose, i, j):
                if found < pair.shape[0]:
                    pair[found, 0], pair[found, 1] = i, j
                found += 1
    return found
