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

from engine.compile.jit import kernel
from engine.constrain.coordinate import bounded_rows
from engine.constrain.direct import apply_all, assemble, factor, solve, solve_bounded
from engine.constrain.joint_rows import equality_rows
from engine.constrain.projection import ROUND_OFF, widest_gap
from engine.integrate.semi_implicit_euler import drift, kick
from engine.maths.vec import Floats, Ints, axpy, load3, load4, quat_turn, store3, store4
from engine.memory.arena import GAP, MOTION, PIVOT, RIGHT, WORK, P, Q, V, W

__all__ = ["joint_gaps", "shake", "solve_joints"]

MAX_ROUNDS = 8


@kernel
def joint_gaps(
    state: Floats,
    joint: Floats,
    joint_kind: Ints,
    joints: int,
    row: Floats,
    row_body: Ints,
    vector: Floats,
    h: float,
    spare: int,
) -> float:
    """Write -C / h of the present state into RIGHT; the rows from `spare` on are overwritten, the earlier ones stay.

    Returns: the widest gap.
    """
    count = equality_rows(state, joint, joint_kind, joints, row[spare:], row_body[spare:])
    for r in range(count):
        vector[RIGHT, r] = -row[spare + r, GAP] / h
    return widest_gap(row[spare:], count)


@kernel
def solve_joints(
    state: Floats, body: Floats, turned: Floats, joint: Floats, joint_kind: Ints, joints: int, row: Floats, row_body: Ints,
    reach: Floats, matrix: Floats, low: Floats, vector: Floats, h: float,
) -> int:  # fmt: skip
    """Change the velocities so that joints hold, and limits, springs and drives act over h.

    Returns: the number of equality rows.
    """
    count = equality_rows(state, joint, joint_kind, joints, row, row_body)
    rows = bounded_rows(state, joint, joint_kind, joints, row, row_body, count, h, 0)
    assemble(row, row_body, 0, rows, body, turned, reach, matrix)
    solve_bounded(state, row, row_body, count, rows, body, turned, reach, matrix, low, vector, 0)
    return count


@kernel
def shake(
    state: Floats, body: Floats, kind: Ints, turned: Floats, load: Floats, setting: Floats, bodies: int, joint: Floats,
    joint_kind: Ints, joints: int, row: Floats, row_body: Ints, reach: Floats, matrix: Floats, low: Floats, vector: Floats,
    start: Floats, h: float, gyroscopic: int,
) -> None:  # fmt: skip
    """Advance all bodies by h."""
    for b in range(bodies):
        kick(state, body, kind, turned, load, setting, b, h)
        for c in range(7):
            start[b, c] = state[b, c]
    count = solve_joints(state, body, turned, joint, joint_kind, joints, row, row_body, reach, matrix, low, vector, h)
    for r in range(count):
        vector[PIVOT, r] = 0.0
    factor(row, row_body, body, matrix, low, count, vector)
    spare = row.shape[0] // 2
    before = math.inf
    for _ in range(MAX_ROUNDS):
        for b in range(bodies):
            if kind[b, MOTION] != 0:
                store3(state, b, P, axpy(h, load3(state, b, V), load3(start, b, P)))
                store4(state, b, Q, quat_turn(load4(start, b, Q), load3(state, b, W), h))
        widest = joint_gaps(state, joint, joint_kind, joints, row, row_body, vector, h, spare)
        if widest <= ROUND_OFF or not widest < 1e6:
            break
        if widest > before:
            apply_all(state, row, row_body, reach, count, body, turned, vector, WORK, -1.0)
            break
        before = widest
        solve(row, row_body, body, turned, low, count, vector, RIGHT, WORK)
        apply_all(state, row, row_body, reach, count, body, turned, vector, WORK, 1.0)
    for b in range(bodies):
        for c in range(7):
            state[b, c] = start[b, c]
        drift(state, body, kind, turned, b, h, gyroscopic)
