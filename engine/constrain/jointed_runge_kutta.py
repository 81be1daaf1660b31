"""One step of the classical Runge-Kutta method of order four for bodies held by joints, on the full smooth dynamics.

In each stage the accelerations follow from the Newton-Euler equations and the constraints,

    a = M^-1 (f + J^T lambda),   J M^-1 J^T lambda = -(J M^-1 f + dJ/dt v),

solved directly. The end of the step is projected onto the constraints, positions first, in the metric of the mass.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, sections VII.1 and VII.2 (index reduction and projection);
Featherstone, Rigid Body Dynamics Algorithms, section 8.5.
"""

from typing import NamedTuple

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.careful import careful_apply, careful_solve
from plumbline.engine.constrain.coordinate import coordinate_row, explicit_force
from plumbline.engine.constrain.direct import apply_all, assemble, factor, is_careful, rate, solve
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.projection import project
from plumbline.engine.constrain.reactions import add_reaction, add_reactions
from plumbline.engine.integrate.runge_kutta import quat_rate
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, load6, store3, store4
from plumbline.engine.maths.vec import axpy, cross, dot, quat_turn, quat_unit, scale, sub, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of
from plumbline.engine.memory.tables import Bodies, Joints, Rows


class Stages(NamedTuple):
    """What a step keeps of its stages, (bodies + 1, 13) each: the state at the start, its slope, the weighted sum of slopes."""

    start: Floats
    slope: Floats
    total: Floats


@kernel
def stages_of(floats: Floats, ints: Ints) -> Stages:
    """The room of an arena for stages."""
    return Stages(floats_of(floats, ints, at.START), floats_of(floats, ints, at.SLOPE), floats_of(floats, ints, at.TOTAL))


@kernel
def is_explicit(joints: Joints, j: int) -> bool:
    """Whether joint j has a spring or drive that is not taken implicitly."""
    return bool(joints.kind[j, at.HAS] & (at.HAS_SPRING | at.HAS_DRIVE) & ~joints.kind[j, at.IMPLICIT] != 0)


@kernel
def slopes(bodies: Bodies, joints: Joints, rows: Rows, slope: Floats, setting: Floats, gyroscopic: int, share: float) -> None:
    """Write the accelerations of all dynamic bodies under loads and joints into `slope` (columns V and W).

    Args: share [s]: the part of the step that counts towards what joints carry.
    """
    state, body, turned, row = bodies.state, bodies.body, bodies.turned, rows.row
    g = load3(setting, 0, at.GRAVITY)
    for b in range(state.shape[0]):
        store3(slope, b, at.V, (0.0, 0.0, 0.0))
        store3(slope, b, at.W, (0.0, 0.0, 0.0))
        if bodies.kind[b, at.MOTION] == at.DYNAMIC:
            v, w = load3(state, b, at.V), load3(state, b, at.W)
            store3(
                slope, b, at.V, axpy(-body[b, at.LINEAR_DAMPING], v, axpy(body[b, at.INV_MASS], load3(bodies.load, b, 0), g))
            )
            torque = load3(bodies.load, b, 3)
            if gyroscopic == 1:
                torque = sub(torque, cross(w, angular_momentum(state, body, b)))
            store3(slope, b, at.W, axpy(-body[b, at.ANGULAR_DAMPING], w, sym_vec(load6(turned, b, 0), torque)))
    last = row.shape[0] - 1
    for j in range(joints.joint.shape[0]):
        if is_explicit(joints, j):
            x, rate_of_x = coordinate_row(state, joints, j, rows, last)
            f = explicit_force(joints, j, x, rate_of_x)
            add_reaction(joints, rows, last, share * f)
            for side in range(2):
                b = rows.body[last, side]
                store3(slope, b, at.V, axpy(f * body[b, at.INV_MASS], load3(row, last, 6 * side), load3(slope, b, at.V)))
                push = sym_vec(load6(turned, b, 0), load3(row, last, 6 * side + 3))
                store3(slope, b, at.W, axpy(f, push, load3(slope, b, at.W)))
    n = equality_rows(state, joints, rows)
    assemble(rows, n, bodies)
    for r in range(n):
        total = row[r, at.CURVATURE]
        for side in range(2):
            b = rows.body[r, side]
            total += dot(load3(row, r, 6 * side), load3(slope, b, at.V)) + dot(
                load3(row, r, 6 * side + 3), load3(slope, b, at.W)
            )
        rows.vector[at.RIGHT, r] = -total
        rows.vector[at.PIVOT, r] = 0.0
    factor(rows, n, body)
    if is_careful(rows, n):
        careful_slopes(bodies, joints, rows, n, slope, g, gyroscopic)
        add_reactions(joints, rows, n, at.WORK, share)
        return
    solve(rows, n, bodies, at.RIGHT, at.WORK)
    apply_all(slope, rows, n, bodies, at.WORK, 1.0)
    add_reactions(joints, rows, n, at.WORK, share)


@kernel
def careful_slopes(bodies: Bodies, joints: Joints, rows: Rows, n: int, slope: Floats, g: Vec, gyroscopic: int) -> None:
    """As `slopes`, from n rows and PIVOT at hand, where floats do not carry the accelerations that forces give to free bodies.

    Forces and torques go to the solver as such: divided by a small inertia first, they would drown what the joints leave.
    """
    state, body, row, vector = bodies.state, bodies.body, rows.row, rows.vector
    force = np.zeros((state.shape[0], 6))
    for b in range(state.shape[0] - 1):
        if bodies.kind[b, at.MOTION] == at.DYNAMIC:
            v, w = load3(state, b, at.V), load3(state, b, at.W)
            store3(slope, b, at.V, axpy(-body[b, at.LINEAR_DAMPING], v, g))
            store3(slope, b, at.W, scale(-body[b, at.ANGULAR_DAMPING], w))
            store3(force, b, 0, load3(bodies.load, b, 0))
            torque = load3(bodies.load, b, 3)
            if gyroscopic == 1:
                torque = sub(torque, cross(w, angular_momentum(state, body, b)))
            store3(force, b, 3, torque)
    last = row.shape[0] - 1
    for j in range(joints.joint.shape[0]):
        if is_explicit(joints, j):
            x, rate_of_x = coordinate_row(state, joints, j, rows, last)
            f = explicit_force(joints, j, x, rate_of_x)
            for side in range(2):
                b = rows.body[last, side]
                store3(force, b, 0, axpy(f, load3(row, last, 6 * side), load3(force, b, 0)))
                store3(force, b, 3, axpy(f, load3(row, last, 6 * side + 3), load3(force, b, 3)))
    for r in range(n):
        vector[at.RIGHT, r] = -(row[r, at.CURVATURE] + rate(slope, rows, r))
        vector[at.WORK, r] = 0.0
    careful_solve(rows, n, bodies, at.RIGHT, at.WORK, force)
    careful_apply(slope, rows, n, bodies, at.WORK, 1.0, force)


@kernel
def jointed_runge_kutta(
    bodies: Bodies, joints: Joints, rows: Rows, stages: Stages, setting: Floats, dt: float, gyroscopic: int
) -> None:
    """Advance all bodies by dt."""
    state, kind = bodies.state, bodies.kind
    start, slope, total = stages.start, stages.slope, stages.total
    last = state.shape[0] - 1
    for b in range(last):
        for c in range(13):
            start[b, c] = state[b, c]
            total[b, c] = 0.0
    for stage in range(4):
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        slopes(bodies, joints, rows, slope, setting, gyroscopic, weight * dt / 6.0)
        ahead = 0.5 * dt if stage < 2 else dt
        for b in range(last):
            if kind[b, at.MOTION] == at.KINEMATIC:
                if stage == 0 or stage == 2:
                    store3(state, b, at.P, axpy(ahead, load3(state, b, at.V), load3(start, b, at.P)))
                    store4(state, b, at.Q, quat_turn(load4(start, b, at.Q), load3(state, b, at.W), ahead))
                continue
            if kind[b, at.MOTION] != at.DYNAMIC:
                continue
            store3(slope, b, at.P, load3(state, b, at.V))
            store4(slope, b, at.Q, quat_rate(load4(state, b, at.Q), load3(state, b, at.W)))
            for c in range(13):
                total[b, c] += weight * slope[b, c]
            if stage < 3:
                for c in range(13):
                    state[b, c] = start[b, c] + ahead * slope[b, c]
            else:
                for c in range(13):
                    state[b, c] = start[b, c] + dt / 6.0 * total[b, c]
                store4(state, b, at.Q, quat_unit(load4(state, b, at.Q)))
            turn_inertia(state, bodies.body, bodies.turned, b)
    project(bodies, joints, rows, slope, dt)
