"""Semi-implicit Euler for bodies held by joints: the SHAKE scheme, which closes the joints at the end of the drift.

Kick all velocities; solve limits, springs and drives with the joints; then repeat

    drift from the start with v,   solve J_n M^-1 J_n^T mu = -C / h,   v <- v + M^-1 J_n^T mu

with the Jacobian of the start until the gap C of the end is closed. The scheme is symplectic and does not lose energy, unlike a
projection of the velocities after the drift.

Where a closed loop passes through a singular pose, the Jacobian of the start may be as good as dependent, that of the end not:
the rounds diverge then. A round that widens the gap is taken back, and the little that is left closes with the next steps.

Source: Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977; Hairer, Lubich, Wanner, Geometric Numerical Integration,
section VII.1.4.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.bounded import solve_bounded
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.direct import apply_all, assemble, factor, rate, solve
from plumbline.engine.constrain.joint_rows import equality_rows, write_gaps
from plumbline.engine.constrain.projection import widest_gap
from plumbline.engine.constrain.reactions import add_reactions
from plumbline.engine.constrain.stages import NEW
from plumbline.engine.integrate.semi_implicit_euler import drift, kick
from plumbline.engine.maths.rows import Floats, load3, load4, store3, store4
from plumbline.engine.maths.vec import axpy, quat_turn
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints, Rows

MAX_ROUNDS = 8

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
    for _ in range(MAX_ROUNDS):
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
