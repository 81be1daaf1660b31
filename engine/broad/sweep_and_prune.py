"""Broad phase by sorting along one axis: the shapes in order of their lower bounds, each compared until its upper bound.

The order is kept from search to search, so that the insertion sort finds it almost sorted. The axis is the one along which the
shapes are spread most; another takes over when it spreads them twice as much.

Source: Ericson, Real-Time Collision Detection, section 7.5 (sort and sweep); Baraff, Dynamic Simulation of Non-Penetrating
Rigid Bodies, 1992, section 2.3.
"""

import math

from plumbline.engine.broad.bounds import boxes_overlap
from plumbline.engine.broad.candidates import add_pair, may_move, search_anew
from plumbline.engine.broad.shares import search_in_shares_anew
from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


@kernel
def widest_axis(fat: Floats, shape: Floats, shapes: int, last: int) -> int:
    """The axis along which the variance of the lower bounds is largest, or the last one unless it is beaten twofold."""
    best, most, kept = last, 0.0, 0.0
    for k in range(3):
        number, mean, square = 0, 0.0, 0.0
        for s in range(shapes):
            if shape[s, at.BALL_RADIUS] < math.inf:
                number += 1
                step = fat[s, k] - mean
                mean += step / number
                square += step * (fat[s, k] - mean)
        if k == last:
            kept = square
        if square > most:
            best, most = k, square
    return best if most > 2.0 * kept else last


@kernel
def sort_shapes(floats: Floats, ints: Ints) -> int:
    """Put the shapes into the order of their lower bounds along one axis. Returns: the axis."""
    fat, shape, order = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), ints_of(ints, at.ORDER)
    progress, shapes = ints_of(ints, at.PROGRESS), ints_of(ints, at.COUNT)[0, at.SHAPES]
    axis = widest_axis(fat, shape, shapes, progress[0, at.AXIS])
    progress[0, at.AXIS] = axis
    for rank in range(1, shapes):
        s = order[rank, 0]
        low = fat[s, axis]
        to = rank
        while to > 0 and fat[order[to - 1, 0], axis] > low:
            order[to, 0] = order[to - 1, 0]
            to -= 1
        order[to, 0] = s
    return axis


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, axis: int) -> int:
    """Write the pairs that a range of shapes finds behind them on the axis, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), 0
    shape_kind, kind, shapes = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT)[0, at.SHAPES]
    order = ints_of(ints, at.ORDER)
    for rank in range(first, last):
        s = order[rank, 0]
        if shape[s, at.BALL_RADIUS] == math.inf:
            continue
        high, moves = fat[s, 3 + axis], may_move(shape_kind, kind, s)
        for to in range(rank + 1, shapes):
            t = order[to, 0]
            if fat[t, axis] > high:
                break
            if (moves or may_move(shape_kind, kind, t)) and shape[t, at.BALL_RADIUS] < math.inf and boxes_overlap(fat, s, t):
                found = add_pair(candidate, found, s, t)
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, sort_shapes, search_range)


@parallel_entry
def find_pairs_parallel(floats: Floats, ints: Ints) -> int:
    """As `find_pairs`, on several threads."""
    return search_in_shares_anew(floats, ints, sort_shapes, search_range)
