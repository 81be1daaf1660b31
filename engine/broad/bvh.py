"""Broad phase by a bounding volume hierarchy: a binary tree of axis-aligned boxes, split at the median centre.

Source: Ericson, Real-Time Collision Detection, sections 6.2.1 (top-down, median of the longest axis) and 6.3; Hoare, Commun.
ACM 4, 1961 (selection).
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

LEAF = 4
"""Shapes of a node that is not split further."""

Tree = tuple[Ints, Ints, Floats]
"""member (k,): bounded shapes, those of a node side by side; node (n, 3): first and last of its members, and the first of its
two children or -1; box (n, 6): lower and upper corner [m]."""


@kernel
def select_middle(member: Ints, centre: Floats, axis: int, low: int, high: int) -> None:
    """Reorder member[low:high] so that the one in its middle has no larger centre before it and no smaller one behind it."""
    middle = (low + high) // 2
    left, right = low, high - 1
    while left < right:
        pivot = centre[member[(left + right) // 2], axis]
        i, j = left, right
        while i <= j:
            while centre[member[i], axis] < pivot:
                i += 1
            while centre[member[j], axis] > pivot:
                j -= 1
            if i <= j:
                member[i], member[j] = member[j], member[i]
                i += 1
                j -= 1
        if middle <= j:
            right = j
        elif middle >= i:
            left = i
        else:
            return


@kernel
def build_tree(floats: Floats, ints: Ints) -> Tree:
    """The tree of all bounded shapes."""
    fat, shape = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE)
    shapes = ints_of(ints, at.COUNT)[0, at.SHAPES]
    member, centre, held = np.empty(shapes, np.int64), np.empty((shapes, 3)), 0
    for s in range(shapes):
        if shape[s, at.BALL_RADIUS] < math.inf:
            member[held] = s
            held += 1
            for k in range(3):
                centre[s, k] = 0.5 * (fat[s, k] + fat[s, k + 3])
    node, box = np.empty((2 * held + 1, 3), np.int64), np.empty((2 * held + 1, 6))
    node[0, 0], node[0, 1] = 0, held
    used, current = 1, 0
    while current < used:
        low, high = node[current, 0], node[current, 1]
        axis, spread = 0, -1.0
        for k in range(3):
            box[current, k], box[current, k + 3] = math.inf, -math.inf
            least, most = math.inf, -math.inf
            for c in range(low, high):
                s = member[c]
                box[current, k], box[current, k + 3] = min(box[current, k], fat[s, k]), max(box[current, k + 3], fat[s, k + 3])
                least, most = min(least, centre[s, k]), max(most, centre[s, k])
            if most - least > spread:
                axis, spread = k, most - least
        node[current, 2] = -1
        if high - low > LEAF:
            select_middle(member, centre, axis, low, high)
            node[current, 2] = used
            node[used, 0], node[used, 1] = low, (low + high) // 2
            node[used + 1, 0], node[used + 1, 1] = (low + high) // 2, high
            used += 2
        current += 1
    return member, node, box


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, tree: Tree) -> int:
    """Write the pairs that a range of shapes finds in the tree, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, at.FAT), floats_of(floats, ints, at.SHAPE), 0
    shape_kind, kind = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.BODY_KIND)
    member, node, box = tree
    stack = np.empty(128, np.int64)
    for i in range(first, last):
        if shape[i, at.BALL_RADIUS] == math.inf or not may_move(shape_kind, kind, i):
            continue
        stack[0], waiting = 0, 1
        while waiting > 0:
            waiting -= 1
            current = stack[waiting]
            meets = True
            for k in range(3):
                if fat[i, k] > box[current, k + 3] or box[current, k] > fat[i, k + 3]:
                    meets = False
            if not meets:
                continue
            if node[current, 2] >= 0:
                stack[waiting], stack[waiting + 1] = node[current, 2], node[current, 2] + 1
                waiting += 2
                continue
            for c in range(node[current, 0], node[current, 1]):
                j = member[c]
                if (j > i or not may_move(shape_kind, kind, j)) and i != j and boxes_overlap(fat, i, j):
                    found = add_pair(candidate, found, i, j)
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, build_tree, search_range)


@parallel_entry
def find_candidates(floats: Floats, ints: Ints, threads: int) -> int:
    """Find the candidates anew where they are stale, on threads. Returns: as `search_anew`."""
    return search_in_shares_anew(floats, ints, threads, build_tree, search_range)
