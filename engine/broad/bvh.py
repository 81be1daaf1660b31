"""Broad phase by a bounding volume hierarchy: a binary tree of axis-aligned boxes, split at the median centre.

Source: Ericson, Real-Time Collision Detection, sections 6.2.1 (top-down, median of the longest axis) and 6.3; Hoare, Commun.
ACM 4, 1961 (selection).
"""

import math

import numpy as np

from engine.broad.bounds import boxes_overlap
from engine.broad.candidates import (
    add_unbounded,
    bounds_are_stale,
    keep_candidates,
    may_move,
    write_pairs,
)  # fmt: skip
from engine.compile.jit import entry, kernel
from engine.maths.vec import Floats, Ints
from engine.memory.arena import BALL_RADIUS, BODY_KIND, CANDIDATE, COUNT, FAT, SHAPE, SHAPE_KIND, SHAPES
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DONE

__all__ = ["find_pairs"]

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
    fat, shape = floats_of(floats, ints, FAT), floats_of(floats, ints, SHAPE)
    shapes = ints_of(ints, COUNT)[0, SHAPES]
    member, centre, held = np.empty(shapes, np.int64), np.empty((shapes, 3)), 0
    for s in range(shapes):
        if shape[s, BALL_RADIUS] < math.inf:
            member[held] = s
            held += 1
            for k in range(3):
                centre[s, k] = 0.5 * (fat[s, k] + fat[s, k + 3])
    node, box = np.empty((2 * held + 1, 3), np.int64), np.empty((2 * held + 1, 6))
    node[0, 0], node[0, 1] = 0, held
    used, at = 1, 0
    while at < used:
        low, high = node[at, 0], node[at, 1]
        axis, spread = 0, -1.0
        for k in range(3):
            box[at, k], box[at, k + 3] = math.inf, -math.inf
            least, most = math.inf, -math.inf
            for c in range(low, high):
                s = member[c]
                box[at, k], box[at, k + 3] = min(box[at, k], fat[s, k]), max(box[at, k + 3], fat[s, k + 3])
                least, most = min(least, centre[s, k]), max(most, centre[s, k])
            if most - least > spread:
                axis, spread = k, most - least
        node[at, 2] = -1
        if high - low > LEAF:
            select_middle(member, centre, axis, low, high)
            node[at, 2] = used
            node[used, 0], node[used, 1] = low, (low + high) // 2
            node[used + 1, 0], node[used + 1, 1] = (low + high) // 2, high
            used += 2
        at += 1
    return member, node, box


@kernel
def search_range(floats: Floats, ints: Ints, first: int, last: int, candidate: Ints, tree: Tree) -> int:
    """Write the pairs that a range of shapes finds in the tree, whose widened bounds overlap.

    Returns: their number, perhaps beyond the room.
    """
    fat, shape, found = floats_of(floats, ints, FAT), floats_of(floats, ints, SHAPE), 0
    shape_kind, kind = ints_of(ints, SHAPE_KIND), ints_of(ints, BODY_KIND)
    member, node, box = tree
    stack = np.empty(128, np.int64)
    for i in range(first, last):
        if shape[i, BALL_RADIUS] == math.inf or not may_move(shape_kind, kind, i):
            continue
        stack[0], waiting = 0, 1
        while waiting > 0:
            waiting -= 1
            at = stack[waiting]
            meets = True
            for k in range(3):
                if fat[i, k] > box[at, k + 3] or box[at, k] > fat[i, k + 3]:
                    meets = False
            if not meets:
                continue
            if node[at, 2] >= 0:
                stack[waiting], stack[waiting + 1] = node[at, 2], node[at, 2] + 1
                waiting += 2
                continue
            for c in range(node[at, 0], node[at, 1]):
                j = member[c]
                if (j > i or not may_move(shape_kind, kind, j)) and i != j and boxes_overlap(fat, i, j):
                    if found < candidate.shape[0]:
                        candidate[found, 0], candidate[found, 1] = min(i, j), max(i, j)
                    found += 1
    return found


@entry
def find_pairs(floats: Floats, ints: Ints) -> int:
    """Write the pairs of this step. Returns: DONE, or FULL where the arena has no room for them."""
    if bounds_are_stale(floats, ints):
        tree = build_tree(floats, ints)
        found = search_range(floats, ints, 0, ints_of(ints, COUNT)[0, SHAPES], ints_of(ints, CANDIDATE), tree)
        status = keep_candidates(floats, ints, add_unbounded(floats, ints, found))
        if status != DONE:
            return status
    return write_pairs(floats, ints)
