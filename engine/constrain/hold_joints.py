"""Joints beside contacts: all their rows are set up once a sub-step, and solved anew after each sweep over the contacts.

A soft or bounded row has one impulse in a sub-step, whose law and bounds the solves share: what each gives is counted against
those of the next.

Source: Catto, Soft Constraints, GDC 2011 (accumulated impulses).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.bounded import solve_bounded
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.direct import assemble
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.reactions import add_reactions
from plumbline.engine.constrain.stages import BEGIN, END, Held
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints, Rows


@kernel
def write_rows(bodies: Bodies, joints: Joints, rows: Rows, h: float) -> Held:
    """Write the rows for a sub-step of h [s], at the end of which the gaps are closed, and their matrix."""
    equalities = equality_rows(bodies.state, joints, rows)
    for r in range(equalities):
        if rows.row[r, at.SOFTNESS] == 0.0:
            rows.row[r, at.BIAS] = rows.row[r, at.GAP] / h
    n = bounded_rows(bodies.state, joints, rows, equalities, h, stiff_alone=False)
    assemble(rows, n, bodies)
    return equalities, n


@kernel
def hold_joints(bodies: Bodies, joints: Joints, rows: Rows, equalities: int, n: int, matrix: int) -> None:
    """Solve all rows for the present velocities, and count what soft and bounded rows have given against their law.

    Args: matrix: NEW, or KNOWN from the second time on since it was assembled.
    """
    row, vector = rows.row, rows.vector
    solve_bounded(bodies, rows, equalities, n, matrix)
    add_reactions(joints, rows, n, at.IMPULSE, 1.0)
    for r in range(n):
        if r < equalities and row[r, at.SOFTNESS] == 0.0:
            continue
        impulse = vector[at.IMPULSE, r]
        row[r, at.BIAS] += row[r, at.SOFTNESS] * impulse
        row[r, at.LOW] -= impulse
        row[r, at.HIGH] -= impulse


@kernel
def keep_rotors(joints: Joints, rows: Rows, equalities: int) -> None:
    """Let each rotor have the rate that all impulses of the sub-step have left it with, which is what its row now aims at."""
    for r in range(equalities):
        if rows.row[r, at.SOFTNESS] > 0.0:
            joints.joint[rows.body[r, at.JOINT_OF], at.ROTOR_RATE] = -rows.row[r, at.BIAS]


@kernel
def hold(bodies: Bodies, joints: Joints, rows: Rows, held: Held, stage: int, h: float) -> Held:
    """What is done with joints in one stage of a sub-step of h [s]: BEGIN, NEW, KNOWN or END. Returns: the rows."""
    if stage == BEGIN:
        return write_rows(bodies, joints, rows, h)
    if stage == END:
        keep_rotors(joints, rows, held[0])
    else:
        hold_joints(bodies, joints, rows, held[0], held[1], stage)
    return held
