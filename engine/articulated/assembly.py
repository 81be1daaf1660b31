"""Write the trees of a world behind the tables of its arena, and read its joints there."""

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.forest import Forest, Link
from plumbline.engine.build.assembly import grow, write_laws
from plumbline.engine.build.solids import quat_mat, quat_mul
from plumbline.engine.maths.arrays import dot, mat_vec
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at

DEGREES = {at.FIXED: 0, at.BALL: 3, at.REVOLUTE: 1, at.PRISMATIC: 1, tree.FREE: 6}
"""The columns of each type of joint."""


def with_trees(floats: Floats, ints: Ints, forest: Forest) -> tuple[Floats, Ints]:
    """The memory of a world with that of its trees, at the start.

    Args: floats, ints: of a world that is assembled; forest: of its bodies and joints, in their order.
    """
    joint_kind = at.int_table(ints, at.JOINT_KIND)
    types = [tree.FREE if link.joint < 0 else int(joint_kind[link.joint, at.JOINT_TYPE]) for link in forest.links]
    n, m, t = len(forest.links), sum(DEGREES[kind] for kind in types), sum(link.tie is not None for link in forest.links)
    pulling = len(forest.tendons)
    held = t + pulling
    answers = [(1 + held) * n, (1 + held) * m]
    rows = (
        [n, n, n, n, m, m + pulling, n, *answers, held * held, held, pulling * m],
        [n, len(forest.others), len(forest.closing), t],
    )
    starts: list[int] = []
    place = len(floats)
    for count, columns in zip(rows[0], tree.FLOAT_COLUMNS.tolist(), strict=True):
        starts += [place, count]
        place += count * columns
    behind = np.zeros(place - len(floats))
    place = len(ints) + 2 * (len(rows[0]) + len(rows[1]))
    for count, columns in zip(rows[1], tree.INT_COLUMNS.tolist(), strict=True):
        starts += [place, count]
        place += count * columns
    tail = np.zeros(place - len(ints) + 1, np.int64)
    tail[: len(starts)], tail[-1] = starts, len(ints)
    floats, ints = np.concatenate((floats, behind)), np.concatenate((ints, tail))
    first = 0
    for k, (link, kind) in enumerate(zip(forest.links, types, strict=True)):
        kin = link.parent, link.body, link.joint, kind, first, DEGREES[kind], link.base, link.root, k, link.root
        tree.int_view(ints, tree.KIND)[k] = kin
        tree.float_view(floats, ints, tree.LAW)[first : first + DEGREES[kind], tree.OWNER] = k
        _write_link(floats, ints, k, link, kind)
        _write_coordinates(floats, ints, k, link, kind)
        first += DEGREES[kind]
    tree.int_view(ints, tree.OTHER)[:, 0] = forest.others
    tree.int_view(ints, tree.CLOSING)[:, 0] = forest.closing
    _write_ties(floats, ints, forest)
    _write_tendons(floats, ints, forest)
    return floats, ints


def _hold_together(kinds: Ints, one: int, other: int) -> None:
    """Let the trees of two links be answered together, with all between them."""
    low, high = sorted(int(kinds[link, tree.CLUSTER]) for link in (one, other))
    kinds[low : int(np.flatnonzero(kinds[:, tree.CLUSTER] == high)[-1]) + 1, tree.CLUSTER] = low


def _write_tendons(floats: Floats, ints: Ints, forest: Forest) -> None:
    """Fill laws and arms of tendons, and which trees they hold together."""
    kinds, arm = tree.int_view(ints, tree.KIND), tree.float_view(floats, ints, tree.ARM)
    law, columns = tree.float_view(floats, ints, tree.LAW), len(tree.float_view(floats, ints, tree.COLUMN))
    for n, (tendon, arms) in enumerate(forest.tendons):
        numbers = np.zeros(at.SPEED_LIMIT + 1)
        law[columns + n, tree.WHICH] = write_laws(numbers, tendon.limits, tendon.spring, tendon.drive)
        law[columns + n, tree.RULE + at.LOWER : tree.RULE + at.SPEED_LIMIT + 1] = numbers[at.LOWER :]
        for link, share in arms.items():
            arm[n * columns + kinds[link, tree.FIRST], 0] = share
            _hold_together(kinds, link, min(arms))


def _write_ties(floats: Floats, ints: Ints, forest: Forest) -> None:
    """Fill who follows whom, and which trees that holds together; all that are tied to laws have the bit `HAS_TIED`."""
    kinds, constants = tree.int_view(ints, tree.KIND), tree.float_view(floats, ints, tree.LINK)
    joint_kind = at.int_table(ints, at.JOINT_KIND)
    law = tree.float_view(floats, ints, tree.LAW)
    constants[:, tree.RATIO], law[:, tree.SHARED], law[:, tree.NEXT_PART] = 1.0, 1.0, -1
    followers = [k for k, link in enumerate(forest.links) if link.tie is not None]
    tree.int_view(ints, tree.FOLLOWER)[:, 0] = followers
    for k in followers:
        tie = forest.links[k].tie
        assert tie is not None
        constants[k, tree.RATIO] = tie.ratio
        column, leader = kinds[[k, tie.leader], tree.FIRST]
        kinds[k, tree.LEADER], law[column, tree.SHARED] = tie.leader, tie.ratio
        law[column, tree.NEXT_PART], law[leader, tree.NEXT_PART] = law[leader, tree.NEXT_PART], column
        _hold_together(kinds, k, tie.leader)
    for leader in {int(kinds[k, tree.LEADER]) for k in followers}:
        joints = kinds[kinds[:, tree.LEADER] == leader, tree.JOINT]
        if joint_kind[joints, at.HAS].any():
            joint_kind[joints, at.HAS] |= at.HAS_TIED


def grow_world(floats: Floats, ints: Ints, trees: bool) -> tuple[Floats, Ints]:
    """The same world with more room for pairs, as `grow`. Args: trees: whether it has any, which stay behind what has grown."""
    if not trees:
        return grow(floats, ints)
    directory = int(ints[-1])
    first = int(ints[directory])
    new_floats, new_ints = grow(floats[:first], ints[:directory])
    tail = ints[directory:].copy()
    entries = 2 * len(tree.FLOAT_COLUMNS), 2 * (len(tree.FLOAT_COLUMNS) + len(tree.INT_COLUMNS))
    tail[: entries[0] : 2] += len(new_floats) - first
    tail[entries[0] : entries[1] : 2] += len(new_ints) - directory
    tail[-1] = len(new_ints)
    return np.concatenate((new_floats, floats[first:])), np.concatenate((new_ints, tail))


def has_same_trees(ints: Ints, other: Ints) -> bool:
    """Whether the integers `other` of a world end in trees like those of `ints`, however much room both have for pairs."""
    length = len(ints) - int(ints[-1])
    if not 0 < length <= len(other) or len(other) - int(other[-1]) != length:
        return False
    rows = slice(1, 2 * (len(tree.FLOAT_COLUMNS) + len(tree.INT_COLUMNS)), 2)
    return bool(np.array_equal(ints[-length:][rows], other[-length:][rows]))


def _write_link(floats: Floats, ints: Ints, k: int, link: Link, kind: int) -> None:
    """Fill what stays of link k: the joint seen from the inner body on, and the mass of the outer one."""
    row, body = tree.float_view(floats, ints, tree.LINK)[k], at.float_table(floats, ints, at.BODY)[link.body]
    row[tree.MASS], row[tree.INERTIA : tree.INERTIA + 6] = body[at.MASS], body[at.INERTIA : at.INERTIA + 6]
    row[tree.LINEAR_DAMPING], row[tree.ANGULAR_DAMPING] = body[at.LINEAR_DAMPING], body[at.ANGULAR_DAMPING]
    row[tree.TURN] = 1.0
    if kind == tree.FREE:
        return
    joint = at.float_table(floats, ints, at.JOINT)[link.joint]
    turn, axis = joint[at.TURN_AB : at.TURN_AB + 4], joint[at.AXIS_A : at.AXIS_A + 3]
    anchors = joint[at.ANCHOR_A : at.ANCHOR_A + 3], joint[at.ANCHOR_B : at.ANCHOR_B + 3]
    if link.against:
        turn, axis, anchors = turn * (1, -1, -1, -1), -joint[at.AXIS_B : at.AXIS_B + 3], anchors[::-1]
    row[tree.TURN : tree.TURN + 4] = turn
    row[tree.TURNED_AXIS : tree.TURNED_AXIS + 4] = quat_mul(np.array([0.0, *axis]), turn)
    row[tree.ANCHOR_A : tree.ANCHOR_A + 3], row[tree.ANCHOR_B : tree.ANCHOR_B + 3] = anchors
    row[tree.AXIS : tree.AXIS + 3] = axis
    row[tree.START_X] = joint[at.POSITION]


def _write_coordinates(floats: Floats, ints: Ints, k: int, link: Link, kind: int) -> None:
    """Fill the coordinates and rates of link k from the state of its bodies."""
    state, row = at.float_table(floats, ints, at.STATE), tree.float_view(floats, ints, tree.COORDINATE)[k]
    constants, columns = tree.float_view(floats, ints, tree.LINK)[k], tree.float_view(floats, ints, tree.COLUMN)
    kinds = tree.int_view(ints, tree.KIND)
    first = kinds[k, tree.FIRST]
    outer = state[link.body]
    inner = state[link.base if link.parent < 0 else kinds[link.parent, tree.ROW]]
    if kind == tree.FREE:
        row[:4], row[tree.POSITION : tree.POSITION + 3] = outer[at.Q : at.Q + 4], outer[:3]
        columns[first : first + 3, tree.RATE], columns[first + 3 : first + 6, tree.RATE] = outer[at.W :], outer[at.V : at.W]
        return
    if link.parent < 0:
        seen = tree.float_view(floats, ints, tree.MOTION)[k, tree.BASE_VELOCITY : tree.BASE_VELOCITY + 6]
        seen[:3], seen[3:] = inner[at.W :], inner[at.V : at.W]
    R = quat_mat(inner[at.Q : at.Q + 4])
    axis = mat_vec(R, constants[tree.AXIS : tree.AXIS + 3])
    w = outer[at.W :] - inner[at.W :]
    if kind == at.BALL:
        row[:4] = constants[tree.TURN : tree.TURN + 4]
        columns[first : first + 3, tree.RATE] = mat_vec(R.T, w)
    elif kind == at.REVOLUTE:
        row[0], columns[first, tree.RATE] = constants[tree.START_X], dot(axis, w)
    elif kind == at.PRISMATIC:
        anchor = inner[:3] + mat_vec(R, constants[tree.ANCHOR_A : tree.ANCHOR_A + 3])
        speed = velocity_at(outer, anchor) - velocity_at(inner, anchor)
        row[0], columns[first, tree.RATE] = constants[tree.START_X], dot(axis, speed)


def motion_of(floats: Floats, ints: Ints, joint: int) -> tuple[float, float]:
    """The coordinate [rad or m] of a joint, and the rate that the velocities of its bodies mean.

    NaN where it has not one coordinate, or closes a loop, whose coordinates are those of its tree.
    """
    kinds = tree.int_view(ints, tree.KIND)
    links = np.flatnonzero((kinds[:, tree.JOINT] == joint) & (kinds[:, tree.COLUMNS] == 1))
    if len(links) == 0:
        return np.nan, np.nan
    link = int(links[0])
    state, row = at.float_table(floats, ints, at.STATE), at.float_table(floats, ints, at.JOINT)[joint]
    kind = at.int_table(ints, at.JOINT_KIND)[joint]
    inner, outer = state[kind[at.PARENT]], state[kind[at.CHILD]]
    axis = mat_vec(quat_mat(inner[at.Q : at.Q + 4]), row[at.AXIS_A : at.AXIS_A + 3])
    if kind[at.JOINT_TYPE] == at.REVOLUTE:
        speed = outer[at.W :] - inner[at.W :]
    else:
        anchor = outer[:3] + mat_vec(quat_mat(outer[at.Q : at.Q + 4]), row[at.ANCHOR_B : at.ANCHOR_B + 3])
        speed = velocity_at(outer, anchor) - velocity_at(inner, anchor)
    return float(tree.float_view(floats, ints, tree.COORDINATE)[link, 0]), float(dot(axis, speed))


def velocity_at(body: Floats, point: Floats) -> Floats:
    """The velocity [m/s] of a body at a point [m] in W."""
    velocity: Floats = body[at.V : at.W] + np.cross(body[at.W :], point - body[:3])
    return velocity
