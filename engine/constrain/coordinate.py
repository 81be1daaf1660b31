"""What acts along the one free coordinate of a joint: limits, spring and drive, as forces or as bounded soft rows.

A spring-damper taken implicitly over h is the soft row  J v + gamma lambda + beta = 0  with
gamma = 1 / (h (c + h k)) and beta = k (x - rest) / (c + h k).

Source: Catto, Soft Constraints, GDC 2011; Lacoursiere, Ghosts and Machines, 2007, section 4.
"""

import math

from engine.compile.jit import kernel
from engine.constrain.joint_rows import anchors, put_row
from engine.maths.vec import (
    Floats,
    Ints,
    add,
    along,
    cross,
    dot,
    load3,
    load4,
    mat_vec,
    neg,
    quat_conj,
    quat_mat,
    quat_mul,
    sub,
)  # fmt: skip
from engine.memory.arena import (
    AXIS_A,
    AXIS_B,
    BIAS,
    CHILD,
    COORDINATE,
    DRIVE,
    HAS,
    HAS_DRIVE,
    HAS_LIMITS,
    HAS_SPRING,
    HIGH,
    IMPLICIT,
    JACOBIAN,
    JOINT_TYPE,
    LOW,
    LOWER,
    PARENT,
    POSITION,
    PRISMATIC,
    REVOLUTE,
    SOFTNESS,
    SPRING,
    TURN_AB,
    UPPER,
    Q,
    V,
    W,
)  # fmt: skip

__all__ = ["bounded_rows", "coordinate_row", "explicit_force", "revolute_angle"]


@kernel
def coordinate_row(
    state: Floats, joint: Floats, joint_kind: Ints, j: int, row: Floats, row_body: Ints, r: int
) -> tuple[float, float]:
    """Write row r, the rate of the coordinate of joint j, and count full turns of a revolute joint.

    Returns: the coordinate [rad or m] and its rate.
    """
    kind, a, b = joint_kind[j, JOINT_TYPE], joint_kind[j, PARENT], joint_kind[j, CHILD]
    ra, rb, d = anchors(state, joint, j, a, b)
    va, wa = load3(state, a, V), load3(state, a, W)
    vb, wb = load3(state, b, V), load3(state, b, W)
    zero = (0.0, 0.0, 0.0)
    if kind == REVOLUTE:
        axis = mat_vec(quat_mat(load4(state, a, Q)), load3(joint, j, AXIS_A))
        put_row(row, row_body, r, a, b, zero, neg(axis), zero, axis, 0.0, 0.0)
        return revolute_angle(state, joint, j, a, b), dot(axis, sub(wb, wa))
    if kind == PRISMATIC:
        axis = mat_vec(quat_mat(load4(state, a, Q)), load3(joint, j, AXIS_A))
        put_row(row, row_body, r, a, b, neg(axis), neg(cross(add(ra, d), axis)), axis, cross(rb, axis), 0.0, 0.0)
        rate = dot(axis, sub(add(vb, cross(wb, rb)), add(va, cross(wa, add(ra, d)))))
        return dot(axis, d) + joint[j, POSITION], rate
    axis = along(d, (0.0, 0.0, 1.0))
    put_row(row, row_body, r, a, b, neg(axis), neg(cross(ra, axis)), axis, cross(rb, axis), 0.0, 0.0)
    return dot(axis, d), dot(axis, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))


@kernel
def revolute_angle(state: Floats, joint: Floats, j: int, a: int, b: int) -> float:
    """The angle [rad] of B against A about the axis, on the branch nearest to the last one."""
    turn = quat_mul(quat_conj(quat_mul(load4(state, a, Q), load4(joint, j, TURN_AB))), load4(state, b, Q))
    axis_in_b = load3(joint, j, AXIS_B)
    angle = 2.0 * math.atan2(dot((turn[1], turn[2], turn[3]), axis_in_b), turn[0])
    angle += float(joint[j, POSITION])
    turns = round((joint[j, COORDINATE] - angle) / (2.0 * math.pi))
    angle += turns * 2.0 * math.pi
    joint[j, COORDINATE] = angle
    return float(angle)


@kernel
def explicit_force(joint: Floats, joint_kind: Ints, j: int, x: float, rate: float) -> float:
    """The force or torque of the spring and drive of joint j that are not taken implicitly [N or N m]."""
    has = joint_kind[j, HAS] & ~joint_kind[j, IMPLICIT]
    f = 0.0
    if has & HAS_SPRING:
        f -= joint[j, SPRING] * (x - joint[j, SPRING + 2]) + joint[j, SPRING + 1] * rate
    if has & HAS_DRIVE:
        limit = joint[j, DRIVE + 4]
        drive = joint[j, DRIVE] * (joint[j, DRIVE + 2] - x) + joint[j, DRIVE + 1] * (joint[j, DRIVE + 3] - rate)
        f += min(max(drive, -limit), limit)
    return float(f)


@kernel
def bounded_rows(
    state: Floats, joint: Floats, joint_kind: Ints, joints: int, row: Floats, row_body: Ints, first: int, h: float, stiff: int
) -> int:
    """Append the rows of limits, and of springs and drives taken implicitly, after row `first`.

    Args: stiff: 1 if only the springs and drives marked as implicit are wanted, 0 for all.
    Returns: the number of rows, equality rows included.
    """
    r = first
    for j in range(joints):
        has = joint_kind[j, HAS]
        if stiff == 1:
            has &= joint_kind[j, IMPLICIT] | HAS_LIMITS
        if has == 0:
            continue
        if has & HAS_LIMITS:
            x, _ = coordinate_row(state, joint, joint_kind, j, row, row_body, r)
            below, above = x - joint[j, LOWER], joint[j, UPPER] - x
            if below <= above:
                row[r, BIAS], row[r, LOW], row[r, HIGH] = below / h, 0.0, math.inf
            else:
                for c in range(JACOBIAN, JACOBIAN + 12):
                    row[r, c] = -row[r, c]
                row[r, BIAS], row[r, LOW], row[r, HIGH] = above / h, 0.0, math.inf
            r += 1
        if has & HAS_SPRING:
            x, _ = coordinate_row(state, joint, joint_kind, j, row, row_body, r)
            k, c = joint[j, SPRING], joint[j, SPRING + 1]
            if c + h * k > 0.0:
                row[r, SOFTNESS] = 1.0 / (h * (c + h * k))
                row[r, BIAS] = k * (x - joint[j, SPRING + 2]) / (c + h * k)
                row[r, LOW], row[r, HIGH] = -math.inf, math.inf
                r += 1
        if has & HAS_DRIVE:
            x, _ = coordinate_row(state, joint, joint_kind, j, row, row_body, r)
            k, c = joint[j, DRIVE], joint[j, DRIVE + 1]
            if c + h * k > 0.0:
                row[r, SOFTNESS] = 1.0 / (h * (c + h * k))
                row[r, BIAS] = (k * (x - joint[j, DRIVE + 2]) - c * joint[j, DRIVE + 3]) / (c + h * k)
                row[r, LOW], row[r, HIGH] = -h * joint[j, DRIVE + 4], h * joint[j, DRIVE + 4]
                r += 1
    return r
