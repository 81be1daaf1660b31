"""Decide which springs and drives are too stiff for the explicit stages of Runge-Kutta and are taken implicitly instead.

The inertia that a coordinate feels, other joints included, is the inverse of the last pivot of J M^-1 J^T with the
coordinate's row placed last (a Schur complement). Explicit stages need dt sqrt(k / m) and dt c / m well below the limit of
stability, 2.78.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.2 (stability domain of order four).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.coordinate import coordinate_row
from plumbline.engine.constrain.direct import assemble, factor, is_careful, solve
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints, Rows

STIFF = 0.1
"""dt^2 k / m above this is taken implicitly."""
DAMPED = 0.3
"""dt c / m above this is taken implicitly."""


@kernel
def mark_stiff(bodies: Bodies, joints: Joints, rows: Rows, dt: float) -> None:
    """Write IMPLICIT for all joints, from the present state."""
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
        if dt * dt * joint[j, at.SPRING] * mobility > STIFF or dt * joint[j, at.SPRING + 1] * mobility > DAMPED:
            kind[j, at.IMPLICIT] |= at.HAS_SPRING
        if dt * dt * joint[j, at.DRIVE] * mobility > STIFF or dt * joint[j, at.DRIVE + 1] * mobility > DAMPED:
            kind[j, at.IMPLICIT] |= at.HAS_DRIVE
