"""Broad phase by a uniform grid: a shape lies in the cell of its centre and meets those of the 27 cells around.

Cells are as wide as the widest shape but for the few that are much wider than the rest, which meet every other shape instead.
Cells are hashed, so a shape far away costs nothing. A pair is found by one of its two shapes: by either, which looks into half
of the cells around it, or, where most shapes stand still, as the triangles of a ground do, by that which moves, in all cells.

Source: Ericson, Real-Time Collision Detection, section 7.1 (grids, hashed storage); Teschner et al., Optimized Spatial Hashing
for Collision Detection of Deformable Objects, 2003.
"""

import math

import numpy as np

from plumbline.engine.broad.bounds import boxes_overlap
from plumbline.engine.broad.candidates import add_pair, may_move, search_anew
from plumbline.engine.broad.shares import search_in_shares_anew
from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.maths.elementary import exp, log
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

LARGE = 4.0
"""Times the geometric mean of all widths from which a shape meets every other one instead of lying in a cell."""
FAR = 1e9
"""Cells are counted up to here; all that lies beyond shares the last one."""
OWN = 13
"""The cell in the middle of the 27, which is a shape's own."""
IN_NONE, OUTSIDE = -1, -2
"""In place of a bucket: of a shape that is too wide for a cell, and of one that lies where nothing can move."""


Grid = tuple[Ints, Ints, Ints, bool]
"""cell (shapes, 4): the cell of a shape, and its bucket, IN_NONE or OUTSIDE; start (buckets + 1,): the first member of
each bucket; member (shapes,): shapes, those of a bucket side by side; around: whether shapes that move look into all 27 cells,
and the others into none."""


@kernel
def width(fat: Floats, s: int) -> float:
    """The largest width [m] of the bounds of shape s."""
    return float(max(max(fat[s, 3] - fat[s, 0], fat[s, 4] - fat[s, 1]), fat[s, 5] - fat[s, 2]))


@kernel
def cell_of(fat: Floats, s: int, k: int, side: float) -> int:
    """The cell of the centre of shape s along axis k."""
    middle = 0.5 * float(fat[s, k] + fat[s, k + 3])
    return math.floor(min(max(middle / side, -FAR), FAR))


@kernel
def bucket_of(x: int, y: int, z: int, buckets: int) -> int:
    """The bucket of a cell; `buckets` is a power of two."""
    return int(((x * 73856093) ^ (y * 19349663) ^ (z * 83492791)) & (buckets - 1))


@kernel
def mark_outside(floats: Floats, ints: Ints, cell: Ints) -> int:
    """Write OUTSIDE to cell[s, 3] of an endless shape and, where most stand still, of what cannot move and lies beyond the box
    of all that can; IN_NONE to that of the rest.

    Returns: the number of the rest.
    """
    fat, shape, kind = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), ints_of(ints, at.BODY_KIND)
    shape_kind, low, high, rest = ints_of(ints, at.SHAPE_KIND), np.full(3, math.inf), np.full(3, -math.inf), 0
    moving = 0
    for s in range(len(cell)):
        bounded = shape[s, at.BALL_RADIUS] < math.inf
        cell[s, 3] = IN_NONE if bounded else OUTSIDE
        rest += 1 if bounded else 0
        moving += 1 if bounded and may_move(shape_kind, kind, s) else 0
    if 2 * moving >= rest:
        return rest
    for s in range(len(cell)):
        if cell[s, 3] == IN_NONE and may_move(shape_kind, kind, s):
            for k in range(3):
                low[k], high[k] = min(low[k], fat[s, k]), max(high[k], fat[s, k + 3])
    for s in range(len(cell)):
        if cell[s, 3] == IN_NONE and not may_move(shape_kind, kind, s):
            beyond = False
            for k in range(3):
                beyond = beyond or fat[s, k] > high[k] or fat[s, k + 3] < low[k]
            if beyond:
                cell[s, 3] = OUTSIDE
                rest -= 1
    return rest


@kernel
def cell_side(fat: Floats, cell: Ints) -> float:
    """The width [m] of the widest shape that lies in a cell, and a millionth more for the rounding of coordinates."""
    number, total = 0, 0.0
    for s in range(len(cell)):
        if cell[s, 3] == IN_NONE:
            number += 1
            total += log(max(width(fat, s), 1e-300))
    most, side = LARGE * exp(total / max(number, 1)), 0.0
    for s in range(len(cell)):
        if cell[s, 3] == IN_NONE and width(fat, s) <= most:
            side = max(side, width(fat, s))
    return float(side * (1.0 + 1e-6))


@kernel
def fill_grid(floats: Floats, ints: Ints) -> Grid:
    """The grid of all bounded shapes but those that lie where nothing can move."""
    fat, kind, shape_kind = floats_of(floats, ints, at.FAT), ints_of(ints, at.BODY_KIND), ints_of(ints, at.SHAPE_KIND)
    shapes, inside, moving = ints_of(ints, at.COUNT)[0, at.SHAPES], 0, 0
    cell = np.empty((shapes, 4), np.int64)
    rest = mark_outside(floats, ints, cell)
    side, buckets = cell_side(fat, cell), 1
    while buckets < 2 * rest:
        buckets *= 2
    start = np.zeros(buckets + 1, np.int64)
    for s in range(shapes):
        if cell[s, 3] == IN_NONE and width(fat, s) <= side:
            for k in range(3):
                cell[s, k] = cell_of(fat, s, k, side)
            cell[s, 3] = bucket_of(cell[s, 0], cell[s, 1], cell[s, 2], buckets)
            start[cell[s, 3] + 1] += 1
            inside += 1
            moving += 1 if may_move(shape_kind, kind, s) else 0
    for c in range(buckets):
        start[c + 1] += start[c]
    member, place = np.empty(inside, np.int64), start.copy()
    for s in range(shapes):
        if cell[s, 3] >= 0:
            member[place[cell[s, 3]]] = s
            place[cell[s, 3]] += 1
    return cell, start, member, 27 * moving < 14 * inside


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, grid: Grid) -> int:
    """Write the pairs that a range of shapes finds in the grid, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), 0
    shape_kind, kind, shapes = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT)[0, at.SHAPES]
    cell, start, member, around = grid
    buckets = len(start) - 1
    for i in range(first, last):
        moves = may_move(shape_kind, kind, i)
        if cell[i, 3] == OUTSIDE:
            continue
        if cell[i, 3] == IN_NONE:
            for j in range(shapes):
                wide = cell[j, 3] == IN_NONE
                if shape[j, at.BALL_RADIUS] == math.inf or (wide and j <= i) or not boxes_overlap(fat, i, j):
                    continue
                if moves or may_move(shape_kind, kind, j):
                    found = add_pair(candidate, found, i, j)
            continue
        if around and not moves:
            continue
        for near in range(0 if around else OWN, 27):
            x, y, z = cell[i, 0] + near % 3 - 1, cell[i, 1] + near // 3 % 3 - 1, cell[i, 2] + near // 9 - 1
            bucket = bucket_of(x, y, z, buckets)
            for c in range(start[bucket], start[bucket + 1]):
                j = member[c]
                if cell[j, 0] != x or cell[j, 1] != y or cell[j, 2] != z or not boxes_overlap(fat, i, j):
                    continue
                movable = may_move(shape_kind, kind, j)
                # Of two that look into each other's cells the first finds the other.
                mutual = movable if around else near == OWN
                if (moves or movable) and (j > i or not mutual):
                    found = add_pair(candidate, found, i, j)
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, fill_grid, search_range)


@parallel_entry
def find_pairs_parallel(floats: Floats, ints: Ints) -> int:
    """As `find_pairs`, on several threads."""
    return search_in_shares_anew(floats, ints, fill_grid, search_range)
