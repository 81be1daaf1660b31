"""Candidate pairs under widened bounds: kept while the bounds of this step lie inside, and put into one order.

The pairs handed on are those whose bounds of this step overlap, so they do not depend on when the candidates were found, nor
by which broad phase.

Source: Verlet, Phys. Rev. 159, 1967 (lists with a skin); Catto, Dynamic Bounding Volume Hierarchies, GDC 2019 (fat boxes).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from plumbline.engine.broad.bounds import BLOCK, collision_filter_of, kept_apart, overlap, place_shapes, reaches_plane
from plumbline.engine.compile.jit import inlined, kernel, template
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE, FULL

SKIN = 0.1
"""By how much candidates' bounds are widened on each side, as a share of the shape's bounding radius [1]."""


@inlined
def may_move(shape_kind: Ints, kind: Ints, s: int) -> bool:
    """Whether shape s belongs to a dynamic body."""
    return bool(kind[shape_kind[s, at.OWNER], at.MOTION] == at.DYNAMIC)


@inlined
def add_pair(pair: Ints, found: int, i: int, j: int) -> int:
    """Write shapes i and j, the lower first, behind those that were found, where there is room. Returns: the new number."""
    if found < pair.shape[0]:
        pair[found, 0], pair[found, 1] = min(i, j), max(i, j)
    return found + 1


@kernel
def bounds_are_stale(floats: Floats, ints: Ints) -> bool:
    """Write this step's poses and bounds; where one has left its widened bounds, or a plane moves, widen all anew."""
    shape, bounds, fat = floats_of(floats, ints, at.SHAPE), floats_of(floats, ints, at.BOUNDS), floats_of(floats, ints, at.FAT)
    kind, shape_kind, progress = ints_of(ints, at.BODY_KIND), ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.PROGRESS)
    shapes = ints_of(ints, at.COUNT)[0, at.SHAPES]
    place_shapes(floats, ints)
    stale = progress[0, at.CANDIDATES] < 0
    ground = stale or progress[0, at.ANEW] == 1
    progress[0, at.ANEW] = 0
    for s in range(shapes):
        motion = kind[shape_kind[s, at.OWNER], at.MOTION]
        if motion == at.STATIC and not ground:
            continue
        if shape[s, at.BALL_RADIUS] == math.inf:
            stale = stale or motion == at.KINEMATIC
        for k in range(3):
            stale = stale or bounds[s, k] < fat[s, k] or bounds[s, k + 3] > fat[s, k + 3]
    if stale:
        for s in range(shapes):
            motion = kind[shape_kind[s, at.OWNER], at.MOTION]
            if motion == at.STATIC and not ground:
                continue
            skin = SKIN * shape[s, at.BALL_RADIUS] if motion == at.DYNAMIC else 0.0
            for k in range(3):
                fat[s, k], fat[s, k + 3] = bounds[s, k] - skin, bounds[s, k + 3] + skin
    return bool(stale)


@kernel
def add_unbounded(floats: Floats, ints: Ints, found: int) -> int:
    """Append the pairs of unbounded shapes, which no cell or tree holds, with those that can move. Returns: the new number."""
    shape, pose, fat = floats_of(floats, ints, at.SHAPE), floats_of(floats, ints, at.POSE), floats_of(floats, ints, at.FAT)
    candidate, shapes = ints_of(ints, at.CANDIDATE), ints_of(ints, at.COUNT)[0, at.SHAPES]
    for i in range(shapes):
        if shape[i, at.BALL_RADIUS] < math.inf:
            continue
        for j in range(shapes):
            if shape[j, at.BALL_RADIUS] < math.inf and reaches_plane(fat, pose, i, j):
                found = add_pair(candidate, found, i, j)
    return found


@inlined
def digits_of(i: int, j: int) -> tuple[int, int, int]:
    """What pairs of shapes i < j are sorted by, the least first: where i is in its block, how far behind j comes, the block."""
    return i % BLOCK, j - i, i // BLOCK


@inlined
def rank_of(i: int, j: int, shapes: int) -> int:
    """A number that rises from pair to pair, as `sort_pairs` has them."""
    within, behind, block = digits_of(i, j)
    return (block * shapes + behind) * BLOCK + within


@kernel
def sort_pairs(pair: Ints, n: int, shapes: int) -> None:
    """Sort n pairs by their digits (radix sort: Knuth, The Art of Computer Programming, volume 3, section 5.2.5)."""
    unsorted = np.empty((n, 2), np.int64)
    for digit in range(3):
        start = np.zeros(shapes + 1, np.int64)
        for c in range(n):
            unsorted[c, 0], unsorted[c, 1] = pair[c, 0], pair[c, 1]
            start[digits_of(pair[c, 0], pair[c, 1])[digit] + 1] += 1
        for s in range(shapes):
            start[s + 1] += start[s]
        for c in range(n):
            i, j = unsorted[c, 0], unsorted[c, 1]
            key = digits_of(i, j)[digit]
            pair[start[key], 0], pair[start[key], 1] = i, j
            start[key] += 1


@kernel
def keep_candidates(floats: Floats, ints: Ints, found: int) -> int:
    """Drop the candidates that never touch, and sort the rest.

    Returns: DONE, or FULL where the arena has no room for them.
    """
    rules, candidate = collision_filter_of(floats, ints), ints_of(ints, at.CANDIDATE)
    progress, shapes = ints_of(ints, at.PROGRESS), ints_of(ints, at.COUNT)[0, at.SHAPES]
    if found > candidate.shape[0]:
        progress[0, at.CANDIDATES], ints_of(ints, at.COUNT)[0, at.PAIRS] = -1, found
        return FULL
    kept = 0
    for c in range(found):
        i, j = candidate[c, 0], candidate[c, 1]
        if not kept_apart(rules, i, j):
            candidate[kept, 0], candidate[kept, 1] = i, j
            kept += 1
    sort_pairs(candidate, kept, shapes)
    progress[0, at.CANDIDATES] = kept
    return DONE


@kernel
def compare_candidates(floats: Floats, ints: Ints, first: int, last: int, pair: Ints, candidate: Ints) -> int:
    """Write the candidates of a range whose bounds of this step overlap. Returns: their number, perhaps beyond the room."""
    pose, bounds = floats_of(floats, ints, at.POSE), floats_of(floats, ints, at.BOUNDS)
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    found = 0
    for c in range(first, last):
        i, j = candidate[c, 0], candidate[c, 1]
        if overlap(bounds, shape_kind, pose, i, j):
            found = add_pair(pair, found, i, j)
    return found


@kernel
def count_shapes(_: Floats, ints: Ints) -> int:
    """How many shapes there are."""
    return int(ints_of(ints, at.COUNT)[0, at.SHAPES])


@kernel
def count_pairs(ints: Ints, found: int) -> int:
    """Note how many pairs this step has. Returns: DONE, or FULL where the arena has no room for them."""
    fits = found <= len(ints_of(ints, at.PAIR))
    ints_of(ints, at.COUNT)[0, at.PAIRS], ints_of(ints, at.TALLY)[0, at.SEARCHED] = found, int(fits)
    return DONE if fits else FULL


@kernel
def write_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `count_pairs`."""
    candidate, candidates = ints_of(ints, at.CANDIDATE), ints_of(ints, at.PROGRESS)[0, at.CANDIDATES]
    return count_pairs(ints, compare_candidates(floats, ints, 0, candidates, ints_of(ints, at.PAIR), candidate))


@template
def search_anew(floats: Floats, ints: Ints, build: Callable[..., Any], search: Callable[..., int]) -> int:
    """Write the pairs of this step, and before that, where bounds have left their skins, the candidates.

    Args: build: (floats, ints) -> what is searched: a tuple of tables, a table, or a number; search: (floats, ints, first
        shape, end, candidates, what is searched) -> number of candidates found, perhaps beyond the room.
    Returns: DONE, or FULL where the arena has no room for them.
    """
    if bounds_are_stale(floats, ints):
        among = build(floats, ints)
        found = search(floats, ints, 0, count_shapes(floats, ints), ints_of(ints, at.CANDIDATE), among)
        status = keep_candidates(floats, ints, add_unbounded(floats, ints, found))
        if status != DONE:
            return status
    return write_pairs(floats, ints)
