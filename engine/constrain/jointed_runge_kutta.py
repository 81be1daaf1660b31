"""One step of the classical Runge-Kutta method of order four for bodies held by joints, on the full smooth dynamics.

In each stage the accelerations follow from the Newton-Euler equations and the constraints,

    a = M^-1 (f + J^T lambda),   J M^-1 J^T lambda = -(J M^-1 f + dJ/dt v),

solved directly. The end of the step is projected onto the constraints, positions first, in the metric of the mass.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, sections VII.1 and VII.2 (index reduction and projection);
Featherstone, Rigid Body Dynamics Algorithms, section 8.5.
"""

import numpy as np

from engine.compile.jit import kernel
from engine.constrain.careful import careful_apply, careful_solve
from engine.constrain.coordinate import coordinate_row, explicit_force
from engine.constrain.direct import apply_all, assemble, factor, is_careful, rate, solve
from engine.constrain.joint_rows import equality_rows
from engine.constrain.projection import project
from engine.integrate.runge_kutta import quat_rate
from engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from engine.maths.vec import (
    Floats,
    Ints,
    Vec,
    axpy,
    cross,
    dot,
    load3,
    load4,
    load6,
    quat_turn,
    quat_unit,
    scale,
    store3,
    store4,
    sub,
    sym_vec,
)  # fmt: skip
from engine.memory.arena import (
    ANGULAR_DAMPING,
    CURVATURE,
    DYNAMIC,
    GRAVITY,
    HAS,
    IMPLICIT,
    INV_MASS,
    KINEMATIC,
    LINEAR_DAMPING,
    MOTION,
    PIVOT,
    RIGHT,
    WORK,
    P,
    Q,
    V,
    W,
)  # fmt: skip

__all__ = ["jointed_runge_kutta"]


@kernel
def slopes(
    state: Floats, body: Floats, kind: Ints, turned: Floats, load: Floats, setting: Floats, bodies: int, joint: Floats,
    joint_kind: Ints, joints: int, row: Floats, row_body: Ints, reach: Floats, matrix: Floats, low: Floats, vector: Floats,
    slope: Floats, gyroscopic: int,
) -> None:  # fmt: skip
    """Write the accelerations of all dynamic bodies under loads and joints into `slope` (columns V and W)."""
    g = load3(setting, 0, GRAVITY)
    for b in range(bodies + 1):
        store3(slope, b, V, (0.0, 0.0, 0.0))
        store3(slope, b, W, (0.0, 0.0, 0.0))
        if kind[b, MOTION] == DYNAMIC:
            v, w = load3(state, b, V), load3(state, b, W)
            store3(slope, b, V, axpy(-body[b, LINEAR_DAMPING], v, axpy(body[b, INV_MASS], load3(load, b, 0), g)))
            torque = load3(load, b, 3)
            if gyroscopic == 1:
                torque = sub(torque, cross(w, angular_momentum(state, body, b)))
            store3(slope, b, W, axpy(-body[b, ANGULAR_DAMPING], w, sym_vec(load6(turned, b, 0), torque)))
    last = row.shape[0] - 1
    for j in range(joints):
        if joint_kind[j, HAS] & 6 & ~joint_kind[j, IMPLICIT]:
            x, rate = coordinate_row(state, joint, joint_kind, j, row, row_body, last)
            f = explicit_force(joint, joint_kind, j, x, rate)
            for side in range(2):
                b = row_body[last, side]
                store3(slope, b, V, axpy(f * body[b, INV_MASS], load3(row, last, 6 * side), load3(slope, b, V)))
                push = sym_vec(load6(turned, b, 0), load3(row, last, 6 * side + 3))
                store3(slope, b, W, axpy(f, push, load3(slope, b, W)))
    count = equality_rows(state, joint, joint_kind, joints, row, row_body)
    assemble(row, row_body, 0, count, body, turned, reach, matrix)
    for r in range(count):
        total = row[r, CURVATURE]
        for side in range(2):
            b = row_body[r, side]
            total += dot(load3(row, r, 6 * side), load3(slope, b, V)) + dot(load3(row, r, 6 * side + 3), load3(slope, b, W))
        vector[RIGHT, r] = -total
        vector[PIVOT, r] = 0.0
    factor(row, row_body, body, matrix, low, count, vector)
    if is_careful(count, vector):
        careful_slopes(
            state, body, kind, turned, load, g, bodies, joint, joint_kind, joints, row, row_body, count, low, vector, slope,
            gyroscopic,
        )  # fmt: skip
        return
    solve(row, row_body, body, turned, low, count, vector, RIGHT, WORK)
    apply_all(slope, row, row_body, reach, count, body, turned, vector, WORK, 1.0)


@kernel
def careful_slopes(
    state: Floats, body: Floats, kind: Ints, turned: Floats, load: Floats, g: Vec, bodies: int, joint: Floats,
    joint_kind: Ints, joints: int, row: Floats, row_body: Ints, count: int, low: Floats, vector: Floats, slope: Floats,
    gyroscopic: int,
) -> None:  # fmt: skip
    """As `slopes`, from rows and PIVOT at hand, where floats do not carry the accelerations that forces give to free bodies.

    Forces and torques go to the solver as such: divided by a small inertia first, they would drown what the joints leave.
    """
    force = np.zeros((bodies + 1, 6))
    for b in range(bodies):
        if kind[b, MOTION] == DYNAMIC:
            v, w = load3(state, b, V), load3(state, b, W)
            store3(slope, b, V, axpy(-body[b, LINEAR_DAMPING], v, g))
            store3(slope, b, W, scale(-body[b, ANGULAR_DAMPING], w))
            store3(force, b, 0, load3(load, b, 0))
            torque = load3(load, b, 3)
            if gyroscopic == 1:
                torque = sub(torque, cross(w, angular_momentum(state, body, b)))
            store3(force, b, 3, torque)
    last = row.shape[0] - 1
    for j in range(joints):
        if joint_kind[j, HAS] & 6 & ~joint_kind[j, IMPLICIT]:
            x, rate_of_x = coordinate_row(state, joint, joint_kind, j, row, row_body, last)
            f = explicit_force(joint, joint_kind, j, x, rate_of_x)
            for side in range(2):
                b = row_body[last, side]
                store3(force, b, 0, axpy(f, load3(row, last, 6 * side), load3(force, b, 0)))
                store3(force, b, 3, axpy(f, load3(row, last, 6 * side + 3), load3(force, b, 3)))
    for r in range(count):
        vector[RIGHT, r] = -(row[r, CURVATURE] + rate(slope, row, row_body, r))
        vector[WORK, r] = 0.0
    careful_solve(row, row_body, count, body, turned, low, vector, RIGHT, WORK, force)
    careful_apply(slope, row, row_body, count, body, turned, vector, WORK, 1.0, force)


@kernel
def jointed_runge_kutta(
    state: Floats, body: Floats, kind: Ints, turned: Floats, load: Floats, setting: Floats, bodies: int, joint: Floats,
    joint_kind: Ints, joints: int, row: Floats, row_body: Ints, reach: Floats, matrix: Floats, low: Floats, vector: Floats,
    start: Floats, slope: Floats, total: Floats, dt: float, gyroscopic: int,
) -> None:  # fmt: skip
    """Advance all bodies by dt."""
    for b in range(bodies):
        for c in range(13):
            start[b, c] = state[b, c]
            total[b, c] = 0.0
    for stage in range(4):
        slopes(
            state, body, kind, turned, load, setting, bodies, joint, joint_kind, joints, row, row_body, reach, matrix, low,
            vector, slope, gyroscopic,
        )  # fmt: skip
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        ahead = 0.5 * dt if stage < 2 else dt
        for b in range(bodies):
            if kind[b, MOTION] == KINEMATIC:
                if stage == 0 or stage == 2:
                    store3(state, b, P, axpy(ahead, load3(state, b, V), load3(start, b, P)))
                    store4(state, b, Q, quat_turn(load4(start, b, Q), load3(state, b, W), ahead))
                continue
            if kind[b, MOTION] != DYNAMIC:
                continue
            store3(slope, b, P, load3(state, b, V))
            store4(slope, b, Q, quat_rate(load4(state, b, Q), load3(state, b, W)))
            for c in range(13):
                total[b, c] += weight * slope[b, c]
            if stage < 3:
                for c in range(13):
                    state[b, c] = start[b, c] + ahead * slope[b, c]
            else:
                for c in range(13):
                    state[b, c] = start[b, c] + dt / 6.0 * total[b, c]
                store4(state, b, Q, quat_unit(load4(state, b, Q)))
            turn_inertia(state, body, turned, b)
    project(state, body, kind, turned, bodies, joint, joint_kind, joints, row, row_body, reach, matrix, low, vector, dt)
