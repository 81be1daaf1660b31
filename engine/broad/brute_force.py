"""Broad phase by testing every pair: quadratic, and the oracle of the others."""

import math

from engine.broad.bounds import boxes_overlap
from engine.broad.candidates import (
    add_unbounded,
    bounds_are_stale,
    keep_candidates,
    may_move,
    write_pairs,
)  # fmt: skip
from engine.compile.jit import entry, kernel
from engine.maths.rows import Floats, Ints
from engine.memory import arena as at
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DONE


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, shapes: int) -> int:
    """Write the pairs of bounded shapes, of so many, of which one of a range is the lower, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE)
    shape_kind, kind = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND)
    found = 0
    for i in range(first, last):
        if shape[i, at.BALL_RADIUS] == math.inf:
            continue
        moves = may_move(shape_kind, kind, i)
        for j in range(i + 1, shapes):
            if (moves or may_move(shape_kind, kind, j)) and shape[j, at.BALL_RADIUS] < math.inf and boxes_overlap(fat, i, j):
                if found < candidate.shape[0]:
                    candidate[found, 0], candidate[found, 1] = i, j
                found += 1
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: DONE, or FULL where the arena has no room for them."""
    if bounds_are_stale(floats, ints):
        shapes = ints_of(ints, at.COUNT)[0, at.SHAPES]
        found = search_range(floats, ints, 0, shapes, ints_of(ints, at.CANDIDATE), shapes)
        status = keep_candidates(floats, ints, add_unbounded(floats, ints, found))
        if status != DONE:
            return status
    return write_pairs(floats, ints)
