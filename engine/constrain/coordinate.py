"""What acts along the one free coordinate of a joint, as forces or as bounded rows: limits, friction, springs, drives.

A spring-damper taken implicitly over h is the soft row  J v + gamma lambda + beta = 0  with
gamma = 1 / (h (c + h k)) and beta = k (x - rest) / (c + h k). Dry friction is the hard row J v = 0 with impulses within h times
its bound: it holds where they suffice, else it brakes by all of it. A limit s of speed is two rows, s - J v >= 0 and
s + J v >= 0, each with an impulse that brakes alone.

Source: Catto, Soft Constraints, GDC 2011; Lacoursiere, Ghosts and Machines, 2007, section 4; Hairer, Wanner, Solving Ordinary
Differential Equations II, section IV.2 (stability domain of order four).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.joint_rows import anchors, put_row
from plumbline.engine.maths.elementary import atan2
from plumbline.engine.maths.rows import Floats, load3, load4
from plumbline.engine.maths.vec import add, along, cross, dot, mat_vec, neg, quat_conj, quat_mat, quat_mul, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Joints, Rows

STIFF, DAMPED = 0.1, 0.3
"""dt^2 k / m and dt c / m above which Runge-Kutta takes a spring or drive implicitly: explicit stages need dt sqrt(k / m) and
dt c / m well below the limit of stability, 2.78."""


@kernel
def too_stiff(joint: Floats, j: int, dt: float, mobility: float) -> int:
    """Which of spring and drive of joint j explicit stages do not carry, bits as of HAS. Args: mobility: of its coordinate."""
    bits = 0
    for law, has in ((at.SPRING, at.HAS_SPRING), (at.DRIVE, at.HAS_DRIVE)):
        if dt * dt * joint[j, law] * mobility > STIFF or dt * joint[j, law + 1] * mobility > DAMPED:
            bits |= has
    return bits


@kernel
def coordinate_row(state: Floats, joints: Joints, j: int, rows: Rows, r: int) -> tuple[float, float]:
    """Write row r, the rate of the coordinate of joint j, and count full turns of a revolute joint.

    Returns: the coordinate [rad or m] and its rate.
    """
    joint = joints.joint
    kind, a, b = joints.kind[j, at.JOINT_TYPE], joints.kind[j, at.PARENT], joints.kind[j, at.CHILD]
    ra, rb, d = anchors(state, joint, j, a, b)
    va, wa = load3(state, a, at.V), load3(state, a, at.W)
    vb, wb = load3(state, b, at.V), load3(state, b, at.W)
    zero = (0.0, 0.0, 0.0)
    if kind == at.REVOLUTE:
        axis = mat_vec(quat_mat(load4(state, a, at.Q)), load3(joint, j, at.AXIS_A))
        put_row(rows, r, j, a, b, (zero, neg(axis), zero, axis), 0.0)
        return revolute_angle(state, joint, j, a, b), dot(axis, sub(wb, wa))
    if kind == at.PRISMATIC:
        axis = mat_vec(quat_mat(load4(state, a, at.Q)), load3(joint, j, at.AXIS_A))
        put_row(rows, r, j, a, b, (neg(axis), neg(cross(add(ra, d), axis)), axis, cross(rb, axis)), 0.0)
        rate = dot(axis, sub(add(vb, cross(wb, rb)), add(va, cross(wa, add(ra, d)))))
        return dot(axis, d) + joint[j, at.POSITION], rate
    axis = along(d, (0.0, 0.0, 1.0))
    put_row(rows, r, j, a, b, (neg(axis), neg(cross(ra, axis)), axis, cross(rb, axis)), 0.0)
    return dot(axis, d), dot(axis, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))


@kernel
def revolute_angle(state: Floats, joint: Floats, j: int, a: int, b: int) -> float:
    """The angle [rad] of B against A about the axis, on the branch nearest to the last one."""
    turn = quat_mul(quat_conj(quat_mul(load4(state, a, at.Q), load4(joint, j, at.TURN_AB))), load4(state, b, at.Q))
    axis_in_b = load3(joint, j, at.AXIS_B)
    angle = 2.0 * atan2(dot((turn[1], turn[2], turn[3]), axis_in_b), turn[0])
    angle += float(joint[j, at.POSITION])
    turns = round((joint[j, at.COORDINATE] - angle) / (2.0 * math.pi))
    angle += turns * 2.0 * math.pi
    joint[j, at.COORDINATE] = angle
    return float(angle)


@kernel
def explicit_force(joints: Joints, j: int, x: float, rate: float) -> float:
    """The force or torque of the spring and drive of joint j that are not taken implicitly [N or N m]."""
    joint = joints.joint
    has = joints.kind[j, at.HAS] & ~joints.kind[j, at.IMPLICIT]
    f = 0.0
    if has & at.HAS_SPRING:
        f -= joint[j, at.SPRING] * (x - joint[j, at.SPRING + 2]) + joint[j, at.SPRING + 1] * rate
    if has & at.HAS_DRIVE:
        limit = joint[j, at.DRIVE + 4]
        drive = joint[j, at.DRIVE] * (joint[j, at.DRIVE + 2] - x) + joint[j, at.DRIVE + 1] * (joint[j, at.DRIVE + 3] - rate)
        f += min(max(drive, -limit), limit)
    return float(f)


@kernel
def bound(row: Floats, r: int, bias: float, low: float, high: float) -> int:
    """Let row r aim at this bias within bounds of its impulse. Returns: the next row."""
    row[r, at.BIAS], row[r, at.LOW], row[r, at.HIGH] = bias, low, high
    return r + 1


@kernel
def turn_round(row: Floats, r: int) -> None:
    """Let row r say the opposite."""
    for c in range(at.JACOBIAN, at.JACOBIAN + 12):
        row[r, c] = -row[r, c]


@kernel
def rows_of_joint(state: Floats, joints: Joints, j: int, has: int, rows: Rows, r: int, h: float) -> int:
    """Write the rows of what joint j has of limits, friction, spring and drive, bits as of HAS, from row r on.

    Returns: the next free row.
    """
    joint, row = joints.joint, rows.row
    if has & at.HAS_LIMITS:
        x, _ = coordinate_row(state, joints, j, rows, r)
        below, above = x - joint[j, at.LOWER], joint[j, at.UPPER] - x
        if below > above:
            turn_round(row, r)
        r = bound(row, r, min(below, above) / h, 0.0, math.inf)
    if has & at.HAS_SPEED_LIMIT:
        for way in range(2):
            coordinate_row(state, joints, j, rows, r)
            if way == 0:
                turn_round(row, r)
            r = bound(row, r, joint[j, at.SPEED_LIMIT], 0.0, math.inf)
    if has & at.HAS_FRICTION:
        coordinate_row(state, joints, j, rows, r)
        r = bound(row, r, 0.0, -h * joint[j, at.FRICTION_LOSS], h * joint[j, at.FRICTION_LOSS])
    for law, bit in ((at.SPRING, at.HAS_SPRING), (at.DRIVE, at.HAS_DRIVE)):
        if has & bit:
            x, _ = coordinate_row(state, joints, j, rows, r)
            k, c = joint[j, law], joint[j, law + 1]
            pull, most = k * (x - joint[j, law + 2]), math.inf
            if bit == at.HAS_DRIVE:
                pull, most = pull - c * joint[j, law + 3], h * joint[j, law + 4]
            if c + h * k > 0.0:
                row[r, at.SOFTNESS] = 1.0 / (h * (c + h * k))
                r = bound(row, r, pull / (c + h * k), -most, most)
    return r


@kernel
def bounded_rows(state: Floats, joints: Joints, rows: Rows, first: int, h: float, stiff_alone: bool) -> int:
    """Append the rows of all limits, dry friction, springs and drives, taken implicitly over h, after row `first`.

    Args: stiff_alone: only limits, and those springs and drives that are marked as implicit. Returns: the number of rows,
        equality rows included.
    """
    r = first
    for rank in range(len(joints.order)):
        j = joints.order[rank, 0]
        has = joints.kind[j, at.HAS] & ((joints.kind[j, at.IMPLICIT] | at.HAS_LIMITS) if stiff_alone else -1)
        if has != 0:
            r = rows_of_joint(state, joints, j, has, rows, r, h)
    return r
