"""Bring positions and velocities back onto the joints, by the shortest way in the metric of the mass.

Positions: Gauss-Newton on the gaps, C + J dx = 0 with dx = M^-1 J^T mu. Velocities: J v = 0; limits, and springs and drives
too stiff for explicit stages, act here as bounded rows.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, section VII.2; Hairer, Lubich, Wanner, Geometric Numerical
Integration, section IV.4.
"""

import numpy as np

from engine.compile.jit import kernel
from engine.constrain.coordinate import bounded_rows
from engine.constrain.direct import apply_all, assemble, factor, is_careful, solve, solve_bounded
from engine.constrain.joint_rows import equality_rows
from engine.integrate.semi_implicit_euler import turn_inertia
from engine.maths.vec import Floats, Ints, add, axpy, load3, load4, quat_turn, store3, store4
from engine.memory.arena import DYNAMIC, GAP, MOTION, PIVOT, RIGHT, WORK, P, Q, V, W

__all__ = ["project", "widest_gap"]

ROUND_OFF = 1e-14
"""A gap [m or rad] below this is as good as closed."""

MAX_ROUNDS = 4


@kernel
def widest_gap(row: Floats, count: int) -> float:
    """The largest violation among the rows."""
    widest = 0.0
    for r in range(count):
        widest = max(widest, abs(row[r, GAP]))
    return widest


@kernel
def project(
    state: Floats, body: Floats, kind: Ints, turned: Floats, bodies: int, joint: Floats, joint_kind: Ints, joints: int,
    row: Floats, row_body: Ints, reach: Floats, matrix: Floats, low: Floats, vector: Floats, dt: float,
) -> None:  # fmt: skip
    """Close the gaps of all joints, then remove velocities that would open them."""
    count = equality_rows(state, joint, joint_kind, joints, row, row_body)
    for _ in range(MAX_ROUNDS):
        if widest_gap(row, count) <= ROUND_OFF:
            break
        assemble(row, row_body, 0, count, body, turned, reach, matrix)
        for r in range(count):
            vector[PIVOT, r] = 0.0
            vector[RIGHT, r] = -row[r, GAP]
        factor(row, row_body, body, matrix, low, count, vector)
        solve(row, row_body, body, turned, low, count, vector, RIGHT, WORK)
        careful = is_careful(count, vector)
        if careful:
            change = np.zeros((bodies + 1, 13))
            apply_all(change, row, row_body, reach, count, body, turned, vector, WORK, 1.0)
            for b in range(bodies):
                if kind[b, MOTION] == DYNAMIC:
                    store3(state, b, P, add(load3(change, b, V), load3(state, b, P)))
                    store4(state, b, Q, quat_turn(load4(state, b, Q), load3(change, b, W), 1.0))
        for r in range(0 if careful else count):
            mu = vector[WORK, r]
            for side in range(2):
                b = row_body[r, side]
                if kind[b, MOTION] == DYNAMIC:
                    store3(state, b, P, axpy(mu, load3(reach, r, 6 * side), load3(state, b, P)))
                    store4(state, b, Q, quat_turn(load4(state, b, Q), load3(reach, r, 6 * side + 3), mu))
        for b in range(bodies):
            if kind[b, MOTION] == DYNAMIC:
                turn_inertia(state, body, turned, b)
        count = equality_rows(state, joint, joint_kind, joints, row, row_body)
    rows = bounded_rows(state, joint, joint_kind, joints, row, row_body, count, dt, 1)
    assemble(row, row_body, 0, rows, body, turned, reach, matrix)
    solve_bounded(state, row, row_body, count, rows, body, turned, reach, matrix, low, vector, 0)
