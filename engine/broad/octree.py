"""Broad phase by a loose octree: a shape lies in the smallest cell as wide as itself that holds its centre.

Cells reach half their width beyond their faces, so that a shape lies in one cell only whatever its place, and sizes of any
ratio each find their level.

Source: Ulrich, Loose Octrees, Game Programming Gems, 2000; Ericson, Real-Time Collision Detection, section 7.3.2.
"""

import math

import numpy as np

from plumbline.engine.broad.bounds import boxes_overlap
from plumbline.engine.broad.candidates import add_pair, may_move, search_anew
from plumbline.engine.broad.shares import search_in_shares_anew
from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

DEEPEST = 20
"""Levels below the root; smaller shapes share the cells of the last one."""


Octree = tuple[Ints, Ints, Ints, Floats]
"""child (n, 8): cells or -1; first (n,): the first shape of a cell or -1; following (shapes,): the next one of the same cell or
-1; cube (n, 4): lower corner and side [m]."""


@kernel
def root_cube(fat: Floats, shape: Floats, shapes: int) -> tuple[float, float, float, float]:
    """Lower corner and side [m] of a cube that holds all centres and is no narrower than any shape."""
    low, high, side = np.full(3, math.inf), np.full(3, -math.inf), 1e-300
    for s in range(shapes):
        if shape[s, at.BALL_RADIUS] < math.inf:
            for k in range(3):
                middle = 0.5 * (fat[s, k] + fat[s, k + 3])
                low[k], high[k] = min(low[k], middle), max(high[k], middle)
                side = max(side, fat[s, k + 3] - fat[s, k])
    for k in range(3):
        side = max(side, high[k] - low[k])
    return low[0], low[1], low[2], side * (1.0 + 1e-9)


@kernel
def depth_of(fat: Floats, s: int, side: float) -> int:
    """The deepest level whose cells are no narrower than shape s."""
    wide, depth, cell = max(max(fat[s, 3] - fat[s, 0], fat[s, 4] - fat[s, 1]), fat[s, 5] - fat[s, 2]), 0, 0.5 * side
    while depth < DEEPEST and cell >= wide:
        depth += 1
        cell *= 0.5
    return depth


@kernel
def build_octree(floats: Floats, ints: Ints) -> Octree:
    """The octree of all bounded shapes."""
    fat, shape = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE)
    shapes = ints_of(ints, at.COUNT)[0, at.SHAPES]
    x0, y0, z0, side = root_cube(fat, shape, shapes)
    nodes = 1
    for s in range(shapes):
        if shape[s, at.BALL_RADIUS] < math.inf:
            nodes += depth_of(fat, s, side)
    child, first = np.full((nodes, 8), -1, np.int64), np.full(nodes, -1, np.int64)
    following, cube = np.empty(shapes, np.int64), np.empty((nodes, 4))
    cube[0, 0], cube[0, 1], cube[0, 2], cube[0, 3] = x0, y0, z0, side
    used = 1
    for s in range(shapes - 1, -1, -1):
        if shape[s, at.BALL_RADIUS] == math.inf:
            continue
        cell = 0
        for _ in range(depth_of(fat, s, side)):
            half, octant = 0.5 * cube[cell, 3], 0
            for k in range(3):
                if 0.5 * (fat[s, k] + fat[s, k + 3]) >= cube[cell, k] + half:
                    octant += 1 << k
            if child[cell, octant] < 0:
                child[cell, octant] = used
                for k in range(3):
                    cube[used, k] = cube[cell, k] + (half if octant >> k & 1 else 0.0)
                cube[used, 3] = half
                used += 1
            cell = child[cell, octant]
        following[s] = first[cell]
        first[cell] = s
    return child, first, following, cube


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, octree: Octree) -> int:
    """Write the pairs that a range of shapes finds in the octree, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), 0
    shape_kind, kind = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND)
    child, head, following, cube = octree
    stack = np.empty(8 * DEEPEST + 8, np.int64)
    for i in range(first, last):
        if shape[i, at.BALL_RADIUS] == math.inf or not may_move(shape_kind, kind, i):
            continue
        stack[0], waiting = 0, 1
        while waiting > 0:
            waiting -= 1
            cell = stack[waiting]
            # Widened a little more than by half, for the rounding of the cell's corner.
            loose, meets = 0.5000001 * cube[cell, 3], True
            for k in range(3):
                if fat[i, k] > cube[cell, k] + cube[cell, 3] + loose or fat[i, k + 3] < cube[cell, k] - loose:
                    meets = False
            if not meets:
                continue
            j = head[cell]
            while j >= 0:
                if (j > i or not may_move(shape_kind, kind, j)) and i != j and boxes_overlap(fat, i, j):
                    found = add_pair(candidate, found, i, j)
                j = following[j]
            for octant in range(8):
                if child[cell, octant] >= 0:
                    stack[waiting] = child[cell, octant]
                    waiting += 1
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, build_octree, search_range)


@parallel_entry
def find_candidates(floats: Floats, ints: Ints, threads: int) -> int:
    """Find the candidates anew where they are stale, on threads. Returns: as `search_anew`."""
    return search_in_shares_anew(floats, ints, threads, build_octree, search_range)
