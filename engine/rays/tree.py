"""A tree of bounding boxes over the hulls and triangles of each body, in the body's own frame, where they never move.

Each node halves its solids at the median of their middles, along the longest side of these middles.

Source: Ericson, Real-Time Collision Detection, section 6.2 (top-down construction, median cut).
"""

from typing import NamedTuple

import numpy as np

from plumbline.engine.build.solids import quat_mat
from plumbline.engine.maths.arrays import mat_vec
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at

LEAF = 4
"""Most solids of a leaf."""
PADDING = 1e-9
"""Share of a body's size [1] by which boxes are widened, against rounding."""


class RayTree(NamedTuple):
    """The trees of all bodies, one after the other.

    Terms: root (b, 2): body and root node; node (k, 6) m: least and greatest corner of a box in B; link (k, 2): first of two
    neighbouring children and 0, or first place in `solid` and number of solids of a leaf; solid (s,): row of the table of
    shapes; frame (s, 12): its origin and rotation matrix in B.
    """

    root: Ints
    node: Floats
    link: Ints
    solid: Ints
    frame: Floats


def ray_tree(floats: Floats, ints: Ints) -> RayTree:
    """The trees of all bodies that have hulls or triangles."""
    kinds, shape = at.int_table(ints, at.SHAPE_KIND), at.float_table(floats, ints, at.SHAPE)
    polyhedron = at.int_table(ints, at.POLYHEDRON)
    vertex = at.float_table(floats, ints, at.VERTEX)
    rows = np.flatnonzero(kinds[:, at.TYPE] >= at.HULL)
    turns = np.array([quat_mat(q) for q in shape[rows, at.TURN : at.TURN + 4]])
    frame = np.concatenate([shape[rows, at.OFFSET : at.OFFSET + 3], turns.reshape(-1, 9)], axis=1)
    counts = polyhedron[rows, at.VERTICES]
    each = np.repeat(np.arange(len(rows)), counts)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    corner = np.arange(len(each)) - first[each] + polyhedron[rows, at.FIRST_VERTEX][each]
    corners = mat_vec(turns[each], vertex[corner]) + frame[each, :3]
    low, high = np.minimum.reduceat(corners, first), np.maximum.reduceat(corners, first)
    root, node, link, solid = [], [], [], []
    nodes = solids = 0
    for body in np.unique(kinds[rows, at.OWNER]):
        mine = np.flatnonzero(kinds[rows, at.OWNER] == body)
        order, boxes, links = _halved(low[mine], high[mine])
        leaf = links[:, 1:] > 0
        root.append((body, nodes))
        node.append(boxes)
        link.append(links + np.where(leaf, (solids, 0), (nodes, 0)))
        solid.append(mine[order])
        nodes, solids = nodes + len(boxes), solids + len(mine)
    places = np.concatenate(solid)
    return RayTree(np.array(root, np.int64), np.concatenate(node), np.concatenate(link), rows[places], frame[places])


def _halved(low: Floats, high: Floats) -> tuple[Ints, Floats, Ints]:
    """Order, boxes and links of one tree over boxes (n, 3), level by level."""
    middle = (low + high) / 2
    order = np.arange(len(low))
    start, count = np.array([0]), np.array([len(low)])
    boxes: list[Floats] = []
    links: list[Ints] = []
    below = 1
    while len(start):
        # All runs of a level follow each other without gaps only in the first one: name the members of each.
        run = np.repeat(np.arange(len(start)), count)
        begin = np.concatenate([[0], np.cumsum(count)[:-1]])
        member = np.arange(len(run)) - begin[run] + start[run]
        taken = order[member]
        least, most = np.minimum.reduceat(low[taken], begin), np.maximum.reduceat(high[taken], begin)
        boxes.append(np.concatenate([least, most], axis=1))
        split = count > LEAF
        children = below + 2 * (np.cumsum(split) - 1)
        links.append(
            np.where(split[:, None], np.column_stack([children, np.zeros_like(count)]), np.column_stack([start, count]))
        )
        spread = np.maximum.reduceat(middle[taken], begin) - np.minimum.reduceat(middle[taken], begin)
        key = middle[taken, spread.argmax(axis=1)[run]]
        order[member] = taken[np.lexsort((key, run))]
        half = count[split] // 2
        start = np.stack([start[split], start[split] + half], axis=1).reshape(-1)
        count = np.stack([half, count[split] - half], axis=1).reshape(-1)
        below += len(start)
    node = np.concatenate(boxes)
    pad = PADDING * float(np.abs(node).max())
    return order, node + np.repeat([-pad, pad], 3), np.concatenate(links)
