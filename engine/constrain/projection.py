"""Bodies that joints hold, brought back onto them: by SHAKE within a sub-step of semi-implicit Euler, or by projection.

*SHAKE* closes the joints at the end of the drift. Kick all velocities; solve limits, springs and drives with the joints; repeat

    drift from the start with v,   solve J_n M^-1 J_n^T mu = -C / h,   v <- v + M^-1 J_n^T mu

with the Jacobian of the start until the gap C of the end is closed. The scheme is symplectic and does not lose energy, unlike a
projection of the velocities after the drift. Where a closed loop passes through a singular pose, the Jacobian of the start may
be as good as dependent, that of the end not: the rounds diverge then. A round that widens the gap is taken back, and the little
that is left closes with the next steps.

*Projection* goes by the shortest way in the metric of the mass. Positions: Gauss-Newton on the gaps, C + J dx = 0 with dx =
M^-1 J^T mu. Velocities: J v = 0; limits, and springs and drives too stiff for explicit stages, act here as bounded rows.

Source: Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977; Hairer, Lubich, Wanner, Geometric Numerical Integration,
sections IV.4 and VII.1.4; Hairer, Wanner, Solving Ordinary Differential Equations II, section VII.2.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.bounded import solve_bounded
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.direct import apply_all, assemble, factor, rate, solve
from plumbline.engine.constrain.joint_rows import equality_rows, write_gaps
from plumbline.engine.constrain.reactions import add_reactions
from plumbline.engine.constrain.stages import NEW
from plumbline.engine.integrate.semi_implicit_euler import drift, kick, turn_inertia
from plumbline.engine.maths.rows import Floats, load3, load4, store3, store4
from plumbline.engine.maths.vec import add, axpy, quat_turn
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints, Rows

ROUND_OFF = 1e-14
"""A gap [m or rad] below this is as good as closed."""

MAX_ROUNDS = 4


@kernel
def widest_gap(row: Floats, n: int) -> float:
    """The largest violation among the first n rows."""
    widest = 0.0
    for r in range(n):
        widest = max(widest, abs(row[r, at.GAP]))
    return widest


@kernel
def close_gaps(bodies: Bodies, joints: Joints, rows: Rows, change: Floats) -> int:
    """Move the bodies until the gaps of all joints are closed, in MAX_ROUNDS at most.

    What the rows turn a body by is summed before the body turns: about thin links each may be a whole turn, all of them none.

    Args: change (bodies + 1, 13): room for what moves the bodies.
    Returns: the number of rows, which are those of the last pose.
    """
    state, kind, vector = bodies.state, bodies.kind, rows.vector
    n = equality_rows(state, joints, rows)
    for _ in range(MAX_ROUNDS):
        if widest_gap(rows.row, n) <= ROUND_OFF:
            break
        assemble(rows, n, bodies)
        for r in range(n):
            vector[at.PIVOT, r] = 0.0
            vector[at.RIGHT, r] = -rows.row[r, at.GAP]
        factor(rows, n, bodies.body)
        solve(rows, n, bodies, at.RIGHT, at.WORK)
        for b in range(state.shape[0]):
            store3(change, b, at.V, (0.0, 0.0, 0.0))
            store3(change, b, at.W, (0.0, 0.0, 0.0))
        apply_all(change, rows, n, bodies, at.WORK, 1.0)
        for b in range(state.shape[0]):
            if kind[b, at.MOTION] == at.DYNAMIC:
                store3(state, b, at.P, add(load3(change, b, at.V), load3(state, b, at.P)))
                store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(change, b, at.W), 1.0))
                turn_inertia(state, bodies.body, bodies.turned, b)
        n = equality_rows(state, joints, rows)
    return n


@kernel
def project(bodies: Bodies, joints: Joints, rows: Rows, change: Floats, dt: float) -> None:
    """Close the gaps of all joints, then remove velocities that would open them. Args: change: as of `close_gaps`."""
    n = close_gaps(bodies, joints, rows, change)
    for r in range(n):
        if rows.row[r, at.SOFTNESS] > 0.0:
            rows.row[r, at.BIAS] = -rate(bodies.state, rows, r)
    every = bounded_rows(bodies.state, joints, rows, n, dt, stiff_alone=True)
    assemble(rows, every, bodies)
    solve_bounded(bodies, rows, n, every, NEW)
    add_reactions(joints, rows, every, at.IMPULSE, 1.0)


SHAKE_ROUNDS = 8

CLOSED = 1e-3
"""Of the tolerance of a step: a gap [m or rad] below this is as good as closed."""


@kernel
def joint_gaps(state: Floats, joints: Joints, rows: Rows, n: int, h: float) -> float:
    """Write the gaps C of the present state into the n rows, and -C / h into RIGHT. Returns: the widest gap."""
    write_gaps(state, joints, rows.row)
    for r in range(n):
        rows.vector[at.RIGHT, r] = -rows.row[r, at.GAP] / h
    return widest_gap(rows.row, n)


@kernel
def solve_joints(bodies: Bodies, joints: Joints, rows: Rows, h: float) -> int:
    """Change the velocities so that joints hold, and limits, springs and drives act over h.

    Returns: the number of equality rows, whose factor is at hand.
    """
    equalities = equality_rows(bodies.state, joints, rows)
    n = bounded_rows(bodies.state, joints, rows, equalities, h, stiff_alone=False)
    assemble(rows, n, bodies)
    solve_bounded(bodies, rows, equalities, n, NEW)
    add_reactions(joints, rows, n, at.IMPULSE, 1.0)
    if n > equalities:
        for r in range(equalities):
            rows.vector[at.PIVOT, r] = 0.0
        factor(rows, equalities, bodies.body)
    return equalities


@kernel
def shake(bodies: Bodies, joints: Joints, rows: Rows, start: Floats, setting: Floats, h: float, gyroscopic: int) -> None:
    """Advance all bodies by h. Args: start (bodies + 1, 13): room for the poses at the start."""
    state = bodies.state
    last = state.shape[0] - 1
    for b in range(last):
        kick(bodies, setting, b, h)
        for c in range(7):
            start[b, c] = state[b, c]
    n = solve_joints(bodies, joints, rows, h)
    before, closed = math.inf, CLOSED * setting[0, at.STEP_TOLERANCE]
    for _ in range(SHAKE_ROUNDS):
        for b in range(last):
            if bodies.kind[b, at.MOTION] != at.STATIC:
                store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(start, b, at.P)))
                store4(state, b, at.Q, quat_turn(load4(start, b, at.Q), load3(state, b, at.W), h))
        widest = joint_gaps(state, joints, rows, n, h)
        if widest <= closed or not widest < 1e6:
            break
        if widest > before:
            apply_all(state, rows, n, bodies, at.WORK, -1.0)
            add_reactions(joints, rows, n, at.WORK, -1.0)
            break
        solve(rows, n, bodies, at.RIGHT, at.WORK)
        apply_all(state, rows, n, bodies, at.WORK, 1.0)
        add_reactions(joints, rows, n, at.WORK, 1.0)
        if before < math.inf and widest * widest <= closed * before:
            # What this round leaves is to it as it is to the one before.
            break
        before = widest
    for r in range(n):
        if rows.row[r, at.SOFTNESS] > 0.0:
            joints.joint[rows.body[r, at.JOINT_OF], at.ROTOR_RATE] = rate(state, rows, r)
    for b in range(last):
        for c in range(7):
            state[b, c] = start[b, c]
        drift(bodies, b, h, gyroscopic)
