"""Broad phase by a bounding volume hierarchy: a binary tree of axis-aligned boxes, split at the median centre.

Source: Ericson, Real-Time Collision Detection, section 6.2.1 (top-down, median of the longest axis); Hoare, Commun.
ACM 4, 1961 (selection).
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

LEAF = 4
"""Shapes of a node that is not split further."""


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
    child, sibling, head, following, box = new_tree(2 * held + 1, shapes)
    span = np.empty((2 * held + 1, 2), np.int64)
    span[0, 0], span[0, 1] = 0, held
    used, node = 1, 0
    while node < used:
        low, high = span[node, 0], span[node, 1]
        axis, spread = 0, -1.0
        for k in range(3):
            lower, upper, least, most = math.inf, -math.inf, math.inf, -math.inf
            for c in range(low, high):
                s = member[c]
                lower, upper = min(lower, fat[s, k]), max(upper, fat[s, k + 3])
                least, most = min(least, centre[s, k]), max(most, centre[s, k])
            box[node, k], box[node, k + 3] = lower, upper
            if most - least > spread:
                axis, spread = k, most - least
        if high - low > LEAF:
            middle = (low + high) // 2
            select_middle(member, centre, axis, low, high)
            child[node], sibling[used] = used, used + 1
            span[used, 0], span[used, 1], span[used + 1, 0], span[used + 1, 1] = low, middle, middle, high
            used += 2
        else:
            for c in range(low, high):
                following[member[c]] = head[node]
                head[node] = member[c]
        node += 1
    return child, sibling, head, following, box


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: as `search_anew`."""
    return search_anew(floats, ints, build_tree, search_range)


@parallel_entry
def find_pairs_parallel(floats: Floats, ints: Ints) -> int:
    """As `find_pairs`, on several threads."""
    return search_in_shares_anew(floats, ints, build_tree, search_range)
