"""The equality constraints of the joints: Jacobian, gap and curvature of each scalar row.

A row says J v = 0 with J acting on (v_A, w_A, v_B, w_B); its time derivative is J a + c = 0 with the curvature c = dJ/dt v.

A rotor of inertia A that turns with a coordinate, x' = J v, resists by lambda = -A x'' = -A (J a + c): a soft row, J a + c +
lambda / A = 0. Over a sub-step its impulse is -A (J v - u), u being the rate that the last one left it with: a drift turns
bodies on, and changes what J v is, but no rotor.

Source: Featherstone, Rigid Body Dynamics Algorithms, section 8.2 (loop constraints); Shabana, Computational Dynamics, section
6.4.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec, load3, load4, store3
from plumbline.engine.maths.vec import (
    add,
    along,
    cross,
    dot,
    mat_vec,
    neg,
    norm,
    perpendicular,
    quat_conj,
    quat_mat,
    quat_mul,
    sub,
)
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Joints, Rows

Jacobian = tuple[Vec, Vec, Vec, Vec]
"""Linear and angular part of A, then of B."""

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@kernel
def put_row(rows: Rows, r: int, j: int, a: int, b: int, jacobian: Jacobian, curvature: float) -> None:
    """Write row r of joint j between bodies a and b, without its gap."""
    row = rows.row
    rows.body[r, 0], rows.body[r, 1], rows.body[r, at.JOINT_OF] = a, b, j
    store3(row, r, at.JACOBIAN, jacobian[0])
    store3(row, r, at.JACOBIAN + 3, jacobian[1])
    store3(row, r, at.JACOBIAN + 6, jacobian[2])
    store3(row, r, at.JACOBIAN + 9, jacobian[3])
    row[r, at.CURVATURE] = curvature
    row[r, at.GAP] = row[r, at.SOFTNESS] = row[r, at.BIAS] = row[r, at.LOW] = row[r, at.HIGH] = 0.0


@kernel
def anchors(state: Floats, joint: Floats, j: int, a: int, b: int) -> tuple[Vec, Vec, Vec]:
    """The arms r_A and r_B from the centres of mass to the anchors, and the way d from anchor A to anchor B, in W [m]."""
    ra = mat_vec(quat_mat(load4(state, a, at.Q)), load3(joint, j, at.ANCHOR_A))
    rb = mat_vec(quat_mat(load4(state, b, at.Q)), load3(joint, j, at.ANCHOR_B))
    return ra, rb, sub(add(load3(state, b, at.P), rb), add(load3(state, a, at.P), ra))


@kernel
def write_gaps(state: Floats, joints: Joints, row: Floats) -> None:
    """Write the gaps of the equality rows of all joints for the present state, in their order; a rotor's row has none."""
    r, joint = 0, joints.joint
    for rank in range(len(joints.order)):
        j = joints.order[rank, 0]
        kind, a, b = joints.kind[j, at.JOINT_TYPE], joints.kind[j, at.PARENT], joints.kind[j, at.CHILD]
        _ra, _rb, d = anchors(state, joint, j, a, b)
        if kind in (at.BALL, at.FIXED, at.REVOLUTE):
            for k in range(3):
                row[r + k, at.GAP] = d[k]
            r += 3
        if kind in (at.FIXED, at.PRISMATIC):
            turn = quat_mul(load4(state, b, at.Q), quat_conj(quat_mul(load4(state, a, at.Q), load4(joint, j, at.TURN_AB))))
            sign = 2.0 if turn[0] >= 0.0 else -2.0
            for k in range(3):
                row[r + k, at.GAP] = sign * turn[k + 1]
            r += 3
        if kind in (at.REVOLUTE, at.PRISMATIC):
            turn_a = quat_mat(load4(state, a, at.Q))
            axis_a = mat_vec(turn_a, load3(joint, j, at.AXIS_A))
            t = mat_vec(turn_a, perpendicular(load3(joint, j, at.AXIS_A)))
            open_by = d
            if kind == at.REVOLUTE:
                open_by = cross(axis_a, mat_vec(quat_mat(load4(state, b, at.Q)), load3(joint, j, at.AXIS_B)))
            row[r, at.GAP], row[r + 1, at.GAP] = dot(t, open_by), dot(cross(axis_a, t), open_by)
            r += 3 if joints.kind[j, at.HAS] & at.HAS_ARMATURE else 2
        if kind == at.DISTANCE and joints.kind[j, at.HAS] == 0:
            row[r, at.GAP] = norm(d) - joint[j, at.LENGTH]
            r += 1


@kernel
def equality_rows(state: Floats, joints: Joints, rows: Rows) -> int:
    """Write the equality rows of all joints for the present state, each joint's rotor behind its own.

    Returns: their number.
    """
    r = 0
    joint = joints.joint
    zero = (0.0, 0.0, 0.0)
    for rank in range(len(joints.order)):
        j = joints.order[rank, 0]
        kind, a, b = joints.kind[j, at.JOINT_TYPE], joints.kind[j, at.PARENT], joints.kind[j, at.CHILD]
        ra, rb, d = anchors(state, joint, j, a, b)
        turn_a = quat_mat(load4(state, a, at.Q))
        va, wa = load3(state, a, at.V), load3(state, a, at.W)
        vb, wb = load3(state, b, at.V), load3(state, b, at.W)
        rate = sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra)))
        centripetal = sub(cross(wb, cross(wb, rb)), cross(wa, cross(wa, ra)))
        if kind in (at.BALL, at.FIXED, at.REVOLUTE):
            for k in range(3):
                e = AXES[k]
                jacobian = (neg(e), neg(cross(ra, e)), e, cross(rb, e))
                put_row(rows, r, j, a, b, jacobian, dot(e, centripetal))
                r += 1
        if kind in (at.FIXED, at.PRISMATIC):
            for k in range(3):
                e = AXES[k]
                put_row(rows, r, j, a, b, (zero, neg(e), zero, e), 0.0)
                r += 1
        if kind in (at.REVOLUTE, at.PRISMATIC):
            axis_a = mat_vec(turn_a, load3(joint, j, at.AXIS_A))
            t = mat_vec(turn_a, perpendicular(load3(joint, j, at.AXIS_A)))
            rotor = joints.kind[j, at.HAS] & at.HAS_ARMATURE
            for k in range(3 if rotor else 2):
                n = axis_a if k == 2 else t
                if kind == at.REVOLUTE:
                    jacobian, curvature = (zero, neg(n), zero, n), dot(cross(wa, n), sub(wb, wa))
                else:
                    curvature = dot(cross(wa, cross(wa, n)), d) + 2.0 * dot(cross(wa, n), rate) + dot(n, centripetal)
                    jacobian = (neg(n), neg(cross(add(ra, d), n)), n, cross(rb, n))
                put_row(rows, r, j, a, b, jacobian, curvature)
                t = cross(axis_a, t)
                r += 1
            if rotor:
                rows.row[r - 1, at.SOFTNESS], rows.row[r - 1, at.BIAS] = 1.0 / joint[j, at.ARMATURE], -joint[j, at.ROTOR_RATE]
        if kind == at.DISTANCE and joints.kind[j, at.HAS] == 0:
            length = norm(d)
            u = along(d, (0.0, 0.0, 1.0))
            radial = dot(u, rate)
            curvature = dot(u, centripetal) + (dot(rate, rate) - radial * radial) / max(length, 1e-12)
            jacobian = (neg(u), neg(cross(ra, u)), u, cross(rb, u))
            put_row(rows, r, j, a, b, jacobian, curvature)
            r += 1
    write_gaps(state, joints, rows.row)
    return r
