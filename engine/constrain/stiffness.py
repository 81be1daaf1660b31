"""Decide which springs and drives are too stiff for the explicit stages of Runge-Kutta and are taken implicitly instead.

The inertia that a coordinate feels, other joints included, is the inverse of the last pivot of J M^-1 J^T with the
coordinate's row placed last (a Schur complement). Explicit stages need dt sqrt(k / m) and dt c / m well below the limit of
stability, 2.78.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.2 (stability domain of order four).
"""

from engine.compile.jit import kernel
from engine.constrain.coordinate import coordinate_row
from engine.constrain.direct import assemble, factor, is_careful, solve
from engine.constrain.joint_rows import equality_rows
from engine.maths.vec import Floats, Ints
from engine.memory.arena import DRIVE, HAS, HAS_DRIVE, HAS_SPRING, IMPLICIT, PIVOT, RIGHT, SPRING, WORK

__all__ = ["mark_stiff"]

STIFF = 0.1
"""dt^2 k / m above this is taken implicitly."""
DAMPED = 0.3
"""dt c / m above this is taken implicitly."""


@kernel
def mark_stiff(
    state: Floats, body: Floats, turned: Floats, joint: Floats, joint_kind: Ints, joints: int, row: Floats, row_body: Ints,
    reach: Floats, matrix: Floats, low: Floats, vector: Floats, dt: float,
) -> None:  # fmt: skip
    """Write IMPLICIT for all joints, from the present state."""
    for j in range(joints):
        joint_kind[j, IMPLICIT] = 0
        if joint_kind[j, HAS] & (HAS_SPRING | HAS_DRIVE) == 0:
            continue
        count = equality_rows(state, joint, joint_kind, joints, row, row_body)
        coordinate_row(state, joint, joint_kind, j, row, row_body, count)
        assemble(row, row_body, 0, count + 1, body, turned, reach, matrix)
        for r in range(count + 1):
            vector[PIVOT, r] = vector[RIGHT, r] = 0.0
        factor(row, row_body, body, matrix, low, count + 1, vector)
        if is_careful(count + 1, vector):
            solve(row, row_body, body, turned, low, count + 1, vector, RIGHT, WORK)
        mobility = low[count, count] ** 2 if vector[PIVOT, count] == 0.0 else 0.0
        if dt * dt * joint[j, SPRING] * mobility > STIFF or dt * joint[j, SPRING + 1] * mobility > DAMPED:
            joint_kind[j, IMPLICIT] |= HAS_SPRING
        if dt * dt * joint[j, DRIVE] * mobility > STIFF or dt * joint[j, DRIVE + 1] * mobility > DAMPED:
            joint_kind[j, IMPLICIT] |= HAS_DRIVE
