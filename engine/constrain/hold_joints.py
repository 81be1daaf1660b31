"""Joints beside contacts: their rows for a sub-step, solved directly as often as the contacts are swept."""

from typing import Final

from engine.compile.jit import kernel
from engine.constrain.coordinate import bounded_rows
from engine.constrain.direct import assemble, solve_bounded
from engine.constrain.joint_rows import equality_rows
from engine.memory.arena import BIAS, GAP, HIGH, IMPULSE, LOW, SOFTNESS
from engine.memory.tables import Bodies, Joints, Rows

__all__ = ["KNOWN", "NEW", "hold_joints", "write_rows"]

# Whether the matrix has been solved since it was assembled.
NEW: Final = 0
KNOWN: Final = 1


@kernel
def write_rows(bodies: Bodies, joints: Joints, rows: Rows, h: float) -> tuple[int, int]:
    """Write the rows of all joints for a sub-step of h [s], and their matrix.

    Returns: how many rows are equalities, and how many there are.
    """
    state, row, number = bodies.state, rows.row, joints.joint.shape[0]
    equalities = equality_rows(state, joints.joint, joints.kind, number, row, rows.body)
    for r in range(equalities):
        row[r, BIAS] = row[r, GAP] / h
    count = bounded_rows(state, joints.joint, joints.kind, number, row, rows.body, equalities, h, 0)
    assemble(row, rows.body, 0, count, bodies.body, bodies.turned, rows.reach, rows.matrix)
    return equalities, count


@kernel
def hold_joints(bodies: Bodies, rows: Rows, equalities: int, count: int, matrix: int) -> None:
    """Solve all rows for the present velocities, and count what soft and bounded rows have given against their law.

    Args: matrix: NEW, or KNOWN from the second time on since it was assembled.
    """
    row, vector = rows.row, rows.vector
    solve_bounded(
        bodies.state, row, rows.body, equalities, count, bodies.body, bodies.turned, rows.reach, rows.matrix, rows.factor,
        vector, matrix,
    )  # fmt: skip
    for r in range(equalities, count):
        impulse = vector[IMPULSE, r]
        row[r, BIAS] += row[r, SOFTNESS] * impulse
        row[r, LOW] -= impulse
        row[r, HIGH] -= impulse
