"""Broad phase by a loose octree: a shape lies in the smallest cell as wide as itself that holds its centre.

Cells reach half their width beyond their faces, so that a shape lies in one cell only whatever its place, and sizes of any
ratio each find their level.

Source: Ulrich, Loose Octrees, Game Programming Gems, 2000; Ericson, Real-Time Collision Detection, section 7.3.2.
"""

import math

import numpy as np

from plumbline.engine.broad.candidates import search_anew
from plumbline.engine.broad.shares import search_in_shares_anew
from plumbline.engine.broad.tree import Tree, new_tree, search_range
from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

DEEPEST = 20
"""Levels below the root; smaller shapes share the cells of the last one."""
LOOSE = 0.5000001
"""Share of its side [1] that a cell reaches beyond its faces: a half, and the rounding of its corner."""


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
def build_octree(floats: Floats, ints: Ints) -> Tree:
    """The octree of all bounded shapes."""
    fat, shape = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE)
    shapes = ints_of(ints, at.COUNT)[0, at.SHAPES]
    x, y, z, side = root_cube(fat, shape, shapes)
    cells, used = 1, 1
    for s in range(shapes):
        if shape[s, at.BALL_RADIUS] < math.inf:
            cells += depth_of(fat, s, side)
    child, sibling, head, following, box = new_tree(cells, shapes)
    cube, inside = np.empty((cells, 4)), np.full((cells, 8), -1, np.int64)
    cube[0, 0], cube[0, 1], cube[0, 2], cube[0, 3] = x, y, z, side
    for s in range(shapes - 1, -1, -1):
        if shape[s, at.BALL_RADIUS] == math.inf:
            continue
        cell = 0
        for _ in range(depth_of(fat, s, side)):
            half, octant = 0.5 * cube[cell, 3], 0
            for k in range(3):
                if 0.5 * (fat[s, k] + fat[s, k + 3]) >= cube[cell, k] + half:
                    octant += 1 << k
            if inside[cell, octant] < 0:
                inside[cell, octant] = used
                sibling[used], child[cell] = child[cell], used
                for k in range(3):
                    cube[used, k] = cube[cell, k] + half * (octant >> k & 1)
                cube[used, 3] = half
                used += 1
            cell = inside[cell, octant]
        following[s] = head[cell]
        head[cell] = s
    for cell in range(used):
        for k in range(3):
            box[cell, k] = cube[cell, k] - LOOSE * cube[cell, 3]
            box[cell, k + 3] = cube[cell, k] + (1.0 + LOOSE) * cube[cell, 3]
    return child, sibling, head, following, box


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, build_octree, search_range)


@parallel_entry
def find_pairs_parallel(floats: Floats, ints: Ints) -> int:
    """As `find_pairs`, on several threads."""
    return search_in_shares_anew(floats, ints, build_octree, search_range)
