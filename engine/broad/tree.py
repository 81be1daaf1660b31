"""Trees of boxes over shapes, and the search in them: each shape goes down into whatever its own bounds overlap.

Source: Ericson, Real-Time Collision Detection, section 6.3 (a traversal with a stack of one's own).
"""

import math

import numpy as np

from plumbline.engine.broad.bounds import boxes_overlap
from plumbline.engine.broad.candidates import add_pair, may_move
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of

STACK = 256
"""Nodes that wait to be looked at: for each level of an octree the seven beside the way down, with room to spare."""


Tree = tuple[Ints, Ints, Ints, Ints, Floats]
"""child, sibling, head (nodes,): the first child of each node, its next sibling and its first shape, -1 for none; following
(shapes,): the next shape of the same node, or -1; box (nodes, 6): lower and upper corner [m] of all below a node."""


@kernel
def new_tree(nodes: int, shapes: int) -> Tree:
    """A root without children or shapes, and room for so many nodes."""
    none = np.full((3, nodes), -1, np.int64)
    return none[0], none[1], none[2], np.empty(shapes, np.int64), np.empty((nodes, 6))


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, tree: Tree) -> int:
    """Write the pairs that a range of shapes finds in the tree, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), 0
    shape_kind, kind = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND)
    child, sibling, head, following, box = tree
    stack = np.empty(STACK, np.int64)
    for i in range(first, last):
        if shape[i, at.BALL_RADIUS] == math.inf or not may_move(shape_kind, kind, i):
            continue
        stack[0], waiting = 0, 1
        while waiting > 0:
            waiting -= 1
            node, meets = stack[waiting], True
            for k in range(3):
                meets = meets and fat[i, k] <= box[node, k + 3] and box[node, k] <= fat[i, k + 3]
            if not meets:
                continue
            j = head[node]
            while j >= 0:
                if (j > i or not may_move(shape_kind, kind, j)) and i != j and boxes_overlap(fat, i, j):
                    found = add_pair(candidate, found, i, j)
                j = following[j]
            below = child[node]
            while below >= 0:
                stack[waiting], below = below, sibling[below]
                waiting += 1
    return found
