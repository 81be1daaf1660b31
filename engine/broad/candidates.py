"""Candidate pairs under widened bounds: kept while the bounds of this step lie inside, and put into one order.

The pairs handed on are those whose bounds of this step overlap, so they do not depend on when the candidates were found, nor
by which broad phase.

Source: Verlet, Phys. Rev. 159, 1967 (lists with a skin); Catto, Dynamic Bounding Volume Hierarchies, GDC 2019 (fat boxes).
"""

import math

import numpy as np

from engine.arena import (
    BALL_RADIUS,
    BODY_KIND,
    BOUNDS,
    CANDIDATE,
    CANDIDATES,
    COUNT,
    DT,
    DYNAMIC,
    EXCLUDED,
    EXCLUSIONS,
    FAT,
    KINEMATIC,
    MARGIN,
    MATERIALS,
    MOTION,
    OWNER,
    PAIR,
    PAIRS,
    PLANE,
    POSE,
    PROGRESS,
    SETTING,
    SHAPE,
    SHAPE_KIND,
    SHAPES,
    SIZE,
    SPHERE,
    STATE,
    SURFACE,
    TYPE,
)  # fmt: skip
from engine.broad.volumes import volumes_apart
from engine.broad_phase import boxes_overlap, kept_apart, pose_shapes, reaches_plane, write_bounds
from engine.carve import floats_of, ints_of
from engine.jit import kernel
from engine.vec import Floats, Ints

__all__ = ["add_unbounded", "bounds_are_stale", "keep_candidates", "may_move", "write_pairs"]

SKIN = 0.1
"""By how much candidates' bounds are widened on each side, as a share of the shape's bounding radius [1]."""


@kernel
def may_move(shape_kind: Ints, kind: Ints, s: int) -> bool:
    """Whether shape s belongs to a dynamic body."""
    return bool(kind[shape_kind[s, OWNER], MOTION] == DYNAMIC)


@kernel
def bounds_are_stale(floats: Floats, ints: Ints) -> bool:
    """Write this step's poses and bounds; where one has left its widened bounds, or a plane moves, widen all anew."""
    state, shape, pose = floats_of(floats, ints, STATE), floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE)
    bounds, fat, setting = floats_of(floats, ints, BOUNDS), floats_of(floats, ints, FAT), floats_of(floats, ints, SETTING)
    kind, shape_kind, progress = ints_of(ints, BODY_KIND), ints_of(ints, SHAPE_KIND), ints_of(ints, PROGRESS)
    shapes = ints_of(ints, COUNT)[0, SHAPES]
    pose_shapes(state, shape, shape_kind, shapes, pose)
    write_bounds(state, shape, shape_kind, shapes, pose, bounds, setting[0, MARGIN], setting[0, DT])
    stale = progress[0, CANDIDATES] < 0
    for s in range(shapes):
        if shape[s, BALL_RADIUS] == math.inf:
            stale = stale or kind[shape_kind[s, OWNER], MOTION] == KINEMATIC
        for k in range(3):
            stale = stale or bounds[s, k] < fat[s, k] or bounds[s, k + 3] > fat[s, k + 3]
    if stale:
        for s in range(shapes):
            skin = SKIN * shape[s, BALL_RADIUS] if may_move(shape_kind, kind, s) else 0.0
            for k in range(3):
                fat[s, k], fat[s, k + 3] = bounds[s, k] - skin, bounds[s, k + 3] + skin
    return bool(stale)


@kernel
def add_unbounded(floats: Floats, ints: Ints, found: int) -> int:
    """Append the pairs of unbounded shapes, which no cell or tree holds, with those that can move. Returns: the new number."""
    shape, pose, fat = floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE), floats_of(floats, ints, FAT)
    candidate, shapes = ints_of(ints, CANDIDATE), ints_of(ints, COUNT)[0, SHAPES]
    for i in range(shapes):
        if shape[i, BALL_RADIUS] < math.inf:
            continue
        for j in range(shapes):
            if shape[j, BALL_RADIUS] < math.inf and reaches_plane(fat, pose, i, j):
                if found < candidate.shape[0]:
                    candidate[found, 0], candidate[found, 1] = min(i, j), max(i, j)
                found += 1
    return found


@kernel
def keep_candidates(floats: Floats, ints: Ints, found: int) -> int:
    """Drop the candidates that never touch, and order the rest by their first and then their second shape.

    Returns: 0, or 2 if the arena has no room for them.
    """
    surface, kind, shape_kind = floats_of(floats, ints, SURFACE), ints_of(ints, BODY_KIND), ints_of(ints, SHAPE_KIND)
    excluded, count, candidate = ints_of(ints, EXCLUDED), ints_of(ints, COUNT), ints_of(ints, CANDIDATE)
    progress, shapes = ints_of(ints, PROGRESS), count[0, SHAPES]
    if found > candidate.shape[0]:
        progress[0, CANDIDATES] = -1
        return 2
    kept = 0
    for c in range(found):
        i, j = candidate[c, 0], candidate[c, 1]
        if not kept_apart(shape_kind, kind, surface, count[0, MATERIALS], excluded, count[0, EXCLUSIONS], i, j):
            candidate[kept, 0], candidate[kept, 1] = i, j
            kept += 1
    start, second = np.zeros(shapes + 1, np.int64), np.empty(kept, np.int64)
    for c in range(kept):
        start[candidate[c, 0] + 1] += 1
    for s in range(shapes):
        start[s + 1] += start[s]
    place = start.copy()
    for c in range(kept):
        i, j = candidate[c, 0], candidate[c, 1]
        to = place[i]
        while to > start[i] and second[to - 1] > j:
            second[to] = second[to - 1]
            to -= 1
        second[to] = j
        place[i] += 1
    for s in range(shapes):
        for c in range(start[s], start[s + 1]):
            candidate[c, 0], candidate[c, 1] = s, second[c]
    progress[0, CANDIDATES] = kept
    return 0


@kernel
def write_pairs(floats: Floats, ints: Ints) -> int:
    """Write the candidates whose bounds of this step overlap. Returns: 0, or 2 if the arena has no room for them.

    Spheres, which piles are made of, are compared here: a call that hands over several arrays costs more than the comparison.
    """
    shape, pose, bounds = floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE), floats_of(floats, ints, BOUNDS)
    shape_kind, candidates = ints_of(ints, SHAPE_KIND), ints_of(ints, PROGRESS)[0, CANDIDATES]
    candidate, pair = ints_of(ints, CANDIDATE), ints_of(ints, PAIR)
    found = 0
    for c in range(candidates):
        i, j = candidate[c, 0], candidate[c, 1]
        one, two = shape_kind[i, TYPE], shape_kind[j, TYPE]
        if one == SPHERE and two == SPHERE:
            near = boxes_overlap(bounds, i, j)
            x, y, z = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1], pose[j, 2] - pose[i, 2]
            r = shape[i, SIZE] + shape[j, SIZE] + bounds[i, 6] + bounds[j, 6]
            near = near and x * x + y * y + z * z <= r * r
        elif one == PLANE or two == PLANE:
            near = reaches_plane(bounds, pose, i, j) if one == PLANE else reaches_plane(bounds, pose, j, i)
        else:
            near = boxes_overlap(bounds, i, j) and not volumes_apart(shape, shape_kind, pose, bounds, i, j)
        if near:
            if found < pair.shape[0]:
                pair[found, 0], pair[found, 1] = i, j
            found += 1
    ints_of(ints, COUNT)[0, PAIRS] = found
    return 2 if found > pair.shape[0] else 0
