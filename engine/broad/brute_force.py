"""Broad phase by testing every pair: quadratic, and the oracle of the others."""

import math

from plumbline.engine.broad.bounds import boxes_overlap
from plumbline.engine.broad.candidates import add_pair, count_shapes, may_move, search_anew
from plumbline.engine.broad.shares import search_in_shares_anew
from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, shapes: int) -> int:
    """Write the pairs (i, j) of shapes with overlapping margins, first <= i < last and i < j.

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
                found = add_pair(candidate, found, i, j)
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, count_shapes, search_range)


@parallel_entry
def find_pairs_parallel(floats: Floats, ints: Ints) -> int:
    """As `find_pairs`, on several threads."""
    return search_in_shares_anew(floats, ints, count_shapes, search_range)
