"""Fixed tendons: one force f along l = sum a_k q_k, arm a_k times it along each, with the laws of `laws` along l.

    (a H^-1 a^T + 1 / (h slope)) f = (push / slope - l') / h - a q''_free      on a piece, f = push - slope (l' + h l'')
    (a H^-1 a^T) f = (v - l') / h - a q''_free                                 at a jump, which fixes the rate v at the end

So a tendon is a row beside those of ties (`ties`), softer by what its law gives way: spring, damper and drive are as implicit
as those of a joint, and a bound holds as exactly. A piece without slope is a force that is known. Which piece holds is found
with those of the columns (`bounded`).

Source: as `engine.articulated.ties` and `engine.articulated.laws`; Lacoursiere, Ghosts and Machines, 2007, section 4.
"""

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.laws import middle, piece
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats


@kernel
def along_law(trees: Trees, k: int, table: Floats, c: int) -> float:
    """What stands at c of a table of columns for law k: of its column or, times the arms, of all columns of its tendon."""
    total, columns = 0.0, trees.column.shape[0]
    if k < columns:
        return float(table[k, c])
    for m in range(columns):
        arm = trees.arm[(k - columns) * columns + m, 0]
        if arm != 0.0:
            total += arm * table[m, c]
    return float(total)


@kernel
def length_of(trees: Trees, n: int) -> float:
    """The length of tendon n [m or rad]."""
    total, columns = 0.0, trees.column.shape[0]
    for i in range(trees.kind.shape[0]):
        arm = trees.arm[n * columns + trees.kind[i, tree.FIRST], 0] if trees.kind[i, tree.COLUMNS] == 1 else 0.0
        if arm != 0.0:
            total += arm * trees.coordinate[i, 0]
    return float(total)


@kernel
def row_of(trees: Trees, k: int) -> int:
    """The row of the tendon of law k among ties."""
    return int(trees.follower.shape[0] + k - trees.column.shape[0])


@kernel
def take_piece(trees: Trees, k: int, h: float) -> None:
    """Write the row of the tendon of law k for the segment that this is on, from the present rates on."""
    law, tie, row = trees.law, trees.tie, row_of(trees, k)
    segment, rate = int(law[k, tree.SEGMENT]), along_law(trees, k, trees.column, tree.RATE)
    tie[row, tree.SOFTNESS], tie[row, tree.KNOWN] = 0.0, 0.0
    if segment % 2 == 1:
        tie[row, tree.AIM] = (law[k, tree.BREAK + segment // 2] - rate) / h
        return
    push, slope = piece(law, k, h, middle(law, k, segment // 2, rate))
    if slope > 0.0:
        tie[row, tree.SOFTNESS], tie[row, tree.AIM] = 1.0 / (h * slope), (push / slope - rate) / h
    else:
        tie[row, tree.KNOWN], tie[row, tree.AIM] = 1.0, push
