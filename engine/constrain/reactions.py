"""What joints carry over a step: the impulses of their rows, as a force and a torque on B at its anchor.

A row that moves its anchor has a linear part, and its impulse acts at the anchor on B; one that turns alone has none, and its
impulse is a moment. So the sums of both kinds need no lever.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Joints, Rows

LINEAR_B = at.JACOBIAN + 6
ANGULAR_B = at.JACOBIAN + 9


@kernel
def clear_reactions(joints: Joints) -> None:
    """Begin a step in which no joint has carried anything yet."""
    for rank in range(len(joints.order)):
        j = joints.order[rank, 0]
        for c in range(at.REACTION, at.REACTION + 6):
            joints.joint[j, c] = 0.0


@kernel
def add_reaction(joints: Joints, rows: Rows, r: int, impulse: float) -> None:
    """Count an impulse [N s or N m s] of row r towards what its joint carries."""
    joint, row, j = joints.joint, rows.row, rows.body[r, at.JOINT_OF]
    if row[r, LINEAR_B] != 0.0 or row[r, LINEAR_B + 1] != 0.0 or row[r, LINEAR_B + 2] != 0.0:
        for c in range(3):
            joint[j, at.REACTION + c] += impulse * row[r, LINEAR_B + c]
    else:
        for c in range(3):
            joint[j, at.REACTION + 3 + c] += impulse * row[r, ANGULAR_B + c]


@kernel
def add_reactions(joints: Joints, rows: Rows, n: int, which: int, share: float) -> None:
    """Count share times vector[which] of the first n rows."""
    for r in range(n):
        add_reaction(joints, rows, r, share * rows.vector[which, r])
