"""Write the trees of a world behind the tables of its arena, and read its joints there."""

import numpy as np
from numpy.typing import NDArray

from engine.articulated import tables as to
from engine.articulated.forest import Forest, Link
from engine.build.assembly import grow
from engine.build.solids import quat_mat, quat_mul
from engine.maths.arrays import dot, mat_vec
from engine.memory import arena as at
from engine.memory.arena import float_table, int_table

__all__ = ["grow_world", "has_same_trees", "motion_of", "with_trees"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

DEGREES = {at.FIXED: 0, at.BALL: 3, at.REVOLUTE: 1, at.PRISMATIC: 1, to.FREE: 6}
"""The columns of each type of joint."""


def with_trees(floats: FloatArray, ints: IntArray, forest: Forest) -> tuple[FloatArray, IntArray]:
    """The memory of a world with that of its trees, at the start.

    Args: floats, ints: of a world that is assembled; forest: of its bodies and joints, in their order.
    """
    joint_kind = int_table(ints, at.JOINT_KIND)
    types = [to.FREE if link.joint < 0 else int(joint_kind[link.joint, at.JOINT_TYPE]) for link in forest.links]
    n, m = len(forest.links), sum(DEGREES[kind] for kind in types)
    rows = [n, n, n, n, m, m, n, m, n], [n, len(forest.others), len(forest.closing)]
    starts: list[int] = []
    place = len(floats)
    for count, columns in zip(rows[0], to.FLOAT_COLUMNS.tolist(), strict=True):
        starts += [place, count]
        place += count * columns
    more = np.zeros(place - len(floats))
    place = len(ints) + 2 * (len(rows[0]) + len(rows[1]))
    for count, columns in zip(rows[1], to.INT_COLUMNS.tolist(), strict=True):
        starts += [place, count]
        place += count * columns
    tail = np.zeros(place - len(ints) + 1, np.int64)
    tail[: len(starts)], tail[-1] = starts, len(ints)
    floats, ints = np.concatenate((floats, more)), np.concatenate((ints, tail))
    first = 0
    for k, (link, kind) in enumerate(zip(forest.links, types, strict=True)):
        to.int_view(ints, to.KIND)[k] = link.parent, link.body, link.joint, kind, first, DEGREES[kind], link.base, link.root
        _write_link(floats, ints, k, link, kind)
        _write_coordinates(floats, ints, k, link, kind)
        first += DEGREES[kind]
    to.int_view(ints, to.OTHER)[:, 0] = forest.others
    to.int_view(ints, to.CLOSING)[:, 0] = forest.closing
    return floats, ints


def grow_world(floats: FloatArray, ints: IntArray, trees: bool) -> tuple[FloatArray, IntArray]:
    """The same world with more room for pairs, as `grow`. Args: trees: whether it has any, which stay behind what has grown."""
    if not trees:
        return grow(floats, ints)
    directory = int(ints[-1])
    first = int(ints[directory])
    new_floats, new_ints = grow(floats[:first], ints[:directory])
    tail = ints[directory:].copy()
    entries = 2 * len(to.FLOAT_COLUMNS), 2 * (len(to.FLOAT_COLUMNS) + len(to.INT_COLUMNS))
    tail[: entries[0] : 2] += len(new_floats) - first
    tail[entries[0] : entries[1] : 2] += len(new_ints) - directory
    tail[-1] = len(new_ints)
    return np.concatenate((new_floats, floats[first:])), np.concatenate((new_ints, tail))


def has_same_trees(ints: IntArray, other: IntArray) -> bool:
    """Whether the integers `other` of a world end in trees like those of `ints`, however much room both have for pairs."""
    length = len(ints) - int(ints[-1])
    if not 0 < length <= len(other) or len(other) - int(other[-1]) != length:
        return False
    rows = slice(1, 2 * (len(to.FLOAT_COLUMNS) + len(to.INT_COLUMNS)), 2)
    return bool(np.array_equal(ints[-length:][rows], other[-length:][rows]))


def _write_link(floats: FloatArray, ints: IntArray, k: int, link: Link, kind: int) -> None:
    """Fill what stays of link k: the joint seen from the inner body on, and the mass of the outer one."""
    row, body = to.float_view(floats, ints, to.LINK)[k], float_table(floats, ints, at.BODY)[link.body]
    row[to.MASS], row[to.INERTIA : to.INERTIA + 6] = body[at.MASS], body[at.INERTIA : at.INERTIA + 6]
    row[to.LINEAR_DAMPING], row[to.ANGULAR_DAMPING] = body[at.LINEAR_DAMPING], body[at.ANGULAR_DAMPING]
    row[to.TURN] = 1.0
    if kind == to.FREE:
        return
    joint = float_table(floats, ints, at.JOINT)[link.joint]
    turn, axis = joint[at.TURN_AB : at.TURN_AB + 4], joint[at.AXIS_A : at.AXIS_A + 3]
    anchors = joint[at.ANCHOR_A : at.ANCHOR_A + 3], joint[at.ANCHOR_B : at.ANCHOR_B + 3]
    if link.against:
        turn, axis, anchors = turn * (1, -1, -1, -1), -joint[at.AXIS_B : at.AXIS_B + 3], anchors[::-1]
    row[to.TURN : to.TURN + 4] = turn
    row[to.TURNED_AXIS : to.TURNED_AXIS + 4] = quat_mul(np.array([0.0, *axis]), turn)
    row[to.ANCHOR_A : to.ANCHOR_A + 3], row[to.ANCHOR_B : to.ANCHOR_B + 3] = anchors
    row[to.AXIS : to.AXIS + 3] = axis
    row[to.START_X] = joint[at.POSITION]


def _write_coordinates(floats: FloatArray, ints: IntArray, k: int, link: Link, kind: int) -> None:
    """Fill the coordinates and rates of link k from the state of its bodies."""
    state, row = float_table(floats, ints, at.STATE), to.float_view(floats, ints, to.COORDINATE)[k]
    constants, columns = to.float_view(floats, ints, to.LINK)[k], to.float_view(floats, ints, to.COLUMN)
    kinds = to.int_view(ints, to.KIND)
    first = kinds[k, to.FIRST]
    outer = state[link.body]
    inner = state[link.base if link.parent < 0 else kinds[link.parent, to.ROW]]
    if kind == to.FREE:
        row[:4], row[to.POSITION : to.POSITION + 3] = outer[at.Q : at.Q + 4], outer[:3]
        columns[first : first + 3, to.RATE], columns[first + 3 : first + 6, to.RATE] = outer[at.W :], outer[at.V : at.W]
        return
    if link.parent < 0:
        seen = to.float_view(floats, ints, to.MOTION)[k, to.BASE_VELOCITY : to.BASE_VELOCITY + 6]
        seen[:3], seen[3:] = inner[at.W :], inner[at.V : at.W]
    R = quat_mat(inner[at.Q : at.Q + 4])
    axis = mat_vec(R, constants[to.AXIS : to.AXIS + 3])
    w = outer[at.W :] - inner[at.W :]
    if kind == at.BALL:
        row[:4] = constants[to.TURN : to.TURN + 4]
        columns[first : first + 3, to.RATE] = mat_vec(R.T, w)
    elif kind == at.REVOLUTE:
        row[0], columns[first, to.RATE] = constants[to.START_X], dot(axis, w)
    elif kind == at.PRISMATIC:
        anchor = inner[:3] + mat_vec(R, constants[to.ANCHOR_A : to.ANCHOR_A + 3])
        speed = velocity_at(outer, anchor) - velocity_at(inner, anchor)
        row[0], columns[first, to.RATE] = constants[to.START_X], dot(axis, speed)


def motion_of(floats: FloatArray, ints: IntArray, joint: int) -> tuple[float, float]:
    """The coordinate [rad or m] of a joint, and the rate that the velocities of its bodies mean.

    NaN where it has not one coordinate, or closes a loop, whose coordinates are those of its tree.
    """
    kinds = to.int_view(ints, to.KIND)
    links = np.flatnonzero((kinds[:, to.JOINT] == joint) & (kinds[:, to.COLUMNS] == 1))
    if len(links) == 0:
        return np.nan, np.nan
    link = int(links[0])
    state, row = float_table(floats, ints, at.STATE), float_table(floats, ints, at.JOINT)[joint]
    kind = int_table(ints, at.JOINT_KIND)[joint]
    inner, outer = state[kind[at.PARENT]], state[kind[at.CHILD]]
    axis = mat_vec(quat_mat(inner[at.Q : at.Q + 4]), row[at.AXIS_A : at.AXIS_A + 3])
    if kind[at.JOINT_TYPE] == at.REVOLUTE:
        speed = outer[at.W :] - inner[at.W :]
    else:
        anchor = outer[:3] + mat_vec(quat_mat(outer[at.Q : at.Q + 4]), row[at.ANCHOR_B : at.ANCHOR_B + 3])
        speed = velocity_at(outer, anchor) - velocity_at(inner, anchor)
    return float(to.float_view(floats, ints, to.COORDINATE)[link, 0]), float(dot(axis, speed))


def velocity_at(body: FloatArray, point: FloatArray) -> FloatArray:
    """The velocity [m/s] of a body at a point [m] in W."""
    velocity: FloatArray = body[at.V : at.W] + np.cross(body[at.W :], point - body[:3])
    return velocity
