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
from plumbline.engine.constrain.coordinate import coordinate_row, explicit_force, too_stiff
from plumbline.engine.constrain.direct import apply_all, assemble, factor, is_careful, rate, solve
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.projection import project
from plumbline.engine.constrain.reactions import add_reaction, add_reactions
from plumbline.engine.integrate.runge_kutta import quat_rate
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, load6, store3, store4
from plumbline.engine.maths.vec import add, axpy, cross, quat_turn, quat_unit, scale, sub, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of
from plumbline.engine.memory.tables import Bodies, Joints, Rows


class Stages(NamedTuple):
    """What a step keeps of its stages, (bodies + 1, 13) each: the state at the start, its slope, the weighted sum of slopes;
    and room for forces (bodies + 1, 6)."""

    start: Floats
    slope: Floats
    total: Floats
    force: Floats


@kernel
def stages_of(floats: Floats, ints: Ints) -> Stages:
    """The room of an arena for stages."""
    start = floats_of(floats, ints, at.START)
    room = np.empty((start.shape[0], 6))
    return Stages(start, floats_of(floats, ints, at.SLOPE), floats_of(floats, ints, at.TOTAL), room)


@kernel
def mark_stiff(bodies: Bodies, joints: Joints, rows: Rows, dt: float) -> None:
    """Write IMPLICIT for all joints, from the present state: which springs and drives explicit stages do not carry.

    The inertia that a coordinate feels, other joints included, is the inverse of the last pivot of J M^-1 J^T with the
    coordinate's row placed last (a Schur complement).
    """
    joint, kind, vector = joints.joint, joints.kind, rows.vector
    for j in range(joint.shape[0]):
        kind[j, at.IMPLICIT] = 0
        if kind[j, at.HAS] & (at.HAS_SPRING | at.HAS_DRIVE) == 0:
            continue
        last = equality_rows(bodies.state, joints, rows)
        coordinate_row(bodies.state, joints, j, rows, last)
        assemble(rows, last + 1, bodies)
        for r in range(last + 1):
            vector[at.PIVOT, r] = vector[at.RIGHT, r] = 0.0
        factor(rows, last + 1, bodies.body)
        if is_careful(rows, last + 1):
            solve(rows, last + 1, bodies, at.RIGHT, at.WORK)
        mobility = rows.factor[last, last] * rows.factor[last, last] if vector[at.PIVOT, last] == 0.0 else 0.0
        kind[j, at.IMPLICIT] = too_stiff(joint, j, dt, mobility)


@kernel
def write_forces(
    bodies: Bodies, joints: Joints, rows: Rows, slope: Floats, force: Floats, setting: Floats, gyroscopic: int, share: float
) -> None:
    """Write what gravity and damping give all dynamic bodies into `slope` (columns V and W), and what loads, springs and drives
    push them by into `force` (bodies, 6) N and N m. Args: share: as of `slopes`.
    """
    state, body, row, last = bodies.state, bodies.body, rows.row, rows.row.shape[0] - 1
    for b in range(state.shape[0]):
        for table, first in ((slope, at.V), (force, 0)):
            store3(table, b, first, (0.0, 0.0, 0.0))
            store3(table, b, first + 3, (0.0, 0.0, 0.0))
        if bodies.kind[b, at.MOTION] == at.DYNAMIC:
            v, w = load3(state, b, at.V), load3(state, b, at.W)
            store3(slope, b, at.V, axpy(-body[b, at.LINEAR_DAMPING], v, load3(setting, 0, at.GRAVITY)))
            store3(slope, b, at.W, scale(-body[b, at.ANGULAR_DAMPING], w))
            torque = load3(bodies.load, b, 3)
            if gyroscopic == 1:
                torque = sub(torque, cross(w, angular_momentum(state, body, b)))
            store3(force, b, 0, load3(bodies.load, b, 0))
            store3(force, b, 3, torque)
    for j in range(joints.joint.shape[0]):
        if joints.kind[j, at.HAS] & (at.HAS_SPRING | at.HAS_DRIVE) & ~joints.kind[j, at.IMPLICIT] != 0:
            x, rate_of_x = coordinate_row(state, joints, j, rows, last)
            f = explicit_force(joints, j, x, rate_of_x)
            add_reaction(joints, rows, last, share * f)
            for side in range(2):
                b = rows.body[last, side]
                store3(force, b, 0, axpy(f, load3(row, last, 6 * side), load3(force, b, 0)))
                store3(force, b, 3, axpy(f, load3(row, last, 6 * side + 3), load3(force, b, 3)))


@kernel
def slopes(
    bodies: Bodies, joints: Joints, rows: Rows, slope: Floats, force: Floats, setting: Floats, gyroscopic: int, share: float
) -> None:
    """Write the accelerations of all dynamic bodies under loads and joints into `slope` (columns V and W).

    Where floats do not carry the accelerations that forces give to free bodies, these go to the solver as such: divided by a
    small inertia first, they would drown what the joints leave.

    Args: force (bodies, 6): room; share [s]: the part of the step that counts towards what joints carry.
    """
    state, body, vector = bodies.state, bodies.body, rows.vector
    write_forces(bodies, joints, rows, slope, force, setting, gyroscopic, share)
    n = equality_rows(state, joints, rows)
    assemble(rows, n, bodies)
    for r in range(n):
        vector[at.PIVOT, r] = 0.0
    factor(rows, n, body)
    careful = is_careful(rows, n)
    for b in range(0 if careful else state.shape[0]):
        store3(slope, b, at.V, axpy(body[b, at.INV_MASS], load3(force, b, 0), load3(slope, b, at.V)))
        store3(slope, b, at.W, add(sym_vec(load6(bodies.turned, b, 0), load3(force, b, 3)), load3(slope, b, at.W)))
    for r in range(n):
        vector[at.RIGHT, r] = -(rows.row[r, at.CURVATURE] + rate(slope, rows, r))
        vector[at.WORK, r] = 0.0
    if careful:
        careful_solve(rows, n, bodies, at.RIGHT, at.WORK, force)
        careful_apply(slope, rows, n, bodies, at.WORK, 1.0, force)
    else:
        solve(rows, n, bodies, at.RIGHT, at.WORK)
        apply_all(slope, rows, n, bodies, at.WORK, 1.0)
    add_reactions(joints, rows, n, at.WORK, share)


@kernel
def jointed_runge_kutta(
    bodies: Bodies, joints: Joints, rows: Rows, stages: Stages, setting: Floats, dt: float, gyroscopic: int
) -> None:
    """Advance all bodies by dt."""
    state, kind = bodies.state, bodies.kind
    start, slope, total = stages.start, stages.slope, stages.total
    last, force = state.shape[0] - 1, stages.force
    for b in range(last):
        for c in range(13):
            start[b, c] = state[b, c]
            total[b, c] = 0.0
    for stage in range(4):
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        slopes(bodies, joints, rows, slope, force, setting, gyroscopic, weight * dt / 6.0)
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
