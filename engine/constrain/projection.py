"""Bring positions and velocities back onto the joints, by the shortest way in the metric of the mass.

Positions: Gauss-Newton on the gaps, C + J dx = 0 with dx = M^-1 J^T mu. Velocities: J v = 0; limits, and springs and drives
too stiff for explicit stages, act here as bounded rows.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, section VII.2; Hairer, Lubich, Wanner, Geometric Numerical
Integration, section IV.4.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.bounded import solve_bounded
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.direct import apply_all, assemble, factor, rate, solve
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.reactions import add_reactions
from plumbline.engine.constrain.stages import NEW
from plumbline.engine.integrate.semi_implicit_euler import turn_inertia
from plumbline.engine.maths.rows import Floats, load3, load4, store3, store4
from plumbline.engine.maths.vec import add, quat_turn
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
