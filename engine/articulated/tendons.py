"""Fixed tendons: one force f along l = sum a_k q_k, arm a_k times it along each, with the laws of `laws` along l.

    (a H^-1 a^T + 1 / (h slope)) f = (push / slope - l') / h - a q''_free      on a piece, f = push - slope (l' + h l'')
    (a H^-1 a^T) f = (v - l') / h - a q''_free                                 at a jump, which fixes the rate v at the end

So a tendon is a row beside those of ties (`ties`), softer by what its law gives way: spring, damper and drive are as implicit
as those of a joint, and a bound holds as exactly. A piece without slope is a force that is known. Which piece holds is found
with those of the columns (`bounded`).

Source: as `engine.articulated.ties` and `engine.articulated.laws`; Lacoursiere, Ghosts and Machines, 2007, section 4.
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.laws import first_segment, middle, piece, put_break, put_drive_breaks, segment_after
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.memory import arena as at


@kernel
def along_arms(tables: Tables, n: int, c: int) -> float:
    """The sum of arm times what stands at c of each column, RATE or CHANGE, of tendon n."""
    total, columns = 0.0, tables.column.shape[0]
    for k in range(columns):
        if tables.arm[n * columns + k, 0] != 0.0:
            total += tables.arm[n * columns + k, 0] * tables.column[k, c]
    return float(total)


@kernel
def length_of(tables: Tables, n: int) -> float:
    """The length of tendon n [m or rad]."""
    total, columns = 0.0, tables.column.shape[0]
    for i in range(tables.kind.shape[0]):
        arm = tables.arm[n * columns + tables.kind[i, tree.FIRST], 0] if tables.kind[i, tree.COLUMNS] == 1 else 0.0
        if arm != 0.0:
            total += arm * tables.coordinate[i, 0]
    return float(total)


@kernel
def take_piece(tables: Tables, n: int, h: float) -> None:
    """Write the row of tendon n for the segment that its law is on, from the present rates on."""
    law, row, c = tables.law, tables.follower.shape[0] + n, tables.column.shape[0] + n
    segment, rate = int(law[c, tree.SEGMENT]), along_arms(tables, n, tree.RATE)
    tables.tie[row, tree.SOFTNESS], tables.tie[row, tree.KNOWN] = 0.0, 0.0
    if segment % 2 == 1:
        tables.tie[row, tree.AIM] = (law[c, tree.BREAK + segment // 2] - rate) / h
        return
    push, slope = piece(law, c, tables.tendon, n, h, middle(law, c, segment // 2, rate))
    if slope > 0.0:
        tables.tie[row, tree.SOFTNESS], tables.tie[row, tree.AIM] = 1.0 / (h * slope), (push / slope - rate) / h
    else:
        tables.tie[row, tree.KNOWN], tables.tie[row, tree.AIM] = 1.0, push


@kernel
def take_pieces(tables: Tables, h: float) -> None:
    """Write the rows of all tendons anew, from the present rates on."""
    for n in range(tables.tendon.shape[0]):
        take_piece(tables, n, h)


@kernel
def write_tendons(tables: Tables, h: float) -> int:
    """Write the laws of all tendons for a sub-step h, each on its first segment. Returns: how many breaks they have."""
    law, tendon, breaks = tables.law, tables.tendon, 0
    for n in range(tendon.shape[0]):
        c = tables.column.shape[0] + n
        x = law[c, tree.X] = length_of(tables, n)
        low, high = (tendon[n, at.LOWER] - x) / h, (tendon[n, at.UPPER] - x) / h
        law[c, tree.LOWEST], law[c, tree.HIGHEST], law[c, tree.BREAKS] = low, high, 0.0
        for end in (low, high):
            if math.isfinite(end):
                put_break(law, c, end, 1.0)
        put_drive_breaks(law, c, c, tendon, n, 1.0, h)
        law[c, tree.SEGMENT] = first_segment(law, c, along_arms(tables, n, tree.RATE))
        take_piece(tables, n, h)
        breaks += int(law[c, tree.BREAKS])
    return breaks


@kernel
def beside(tables: Tables, n: int, h: float, side: int) -> float:
    """The force just below (side 0) or above (1) the jump that tendon n is at; infinite beyond the ends of its law."""
    law, c = tables.law, tables.column.shape[0] + n
    at_break = int(law[c, tree.SEGMENT]) // 2
    break_rate = law[c, tree.BREAK + at_break]
    if side == 0 and break_rate == law[c, tree.LOWEST]:
        return math.inf
    if side == 1 and break_rate == law[c, tree.HIGHEST]:
        return -math.inf
    push, slope = piece(law, c, tables.tendon, n, h, middle(law, c, at_break + side, break_rate))
    return float(push - slope * break_rate)


@kernel
def segment_next(tables: Tables, n: int, h: float, rate: float, open_by: float) -> int:
    """The segment that tendon n goes on to; the present one where it is right.

    Args: rate: of its length at the end; open_by: how exactly that is known, beside round-off.
    """
    c, row, rows = tables.column.shape[0] + n, tables.follower.shape[0] + n, tables.tie.shape[0]
    if int(tables.law[c, tree.SEGMENT]) % 2 == 0:
        return segment_after(tables.law, c, rate, open_by, 0.0, 0.0)
    pivot = tables.tie_factor[rows * row + row, 0]
    return segment_after(
        tables.law,
        c,
        tables.tie[row, tree.HOLDS],
        open_by / (h * pivot * pivot),
        beside(tables, n, h, 0),
        beside(tables, n, h, 1),
    )


@kernel
def change_pieces(tables: Tables, h: float, wrong: int, alone: bool) -> int:
    """As `bounded.change_segments`, of tendons. Args: wrong: columns on the wrong segment. Returns: all that were on one."""
    for n in range(tables.tendon.shape[0]):
        c = tables.column.shape[0] + n
        if tables.law[c, tree.BREAKS] == 0.0:
            continue
        segment = segment_next(tables, n, h, along_arms(tables, n, tree.RATE) + h * along_arms(tables, n, tree.CHANGE), 0.0)
        if segment != int(tables.law[c, tree.SEGMENT]):
            wrong += 1
            if wrong == 1 or not alone:
                tables.law[c, tree.SEGMENT] = segment
                take_piece(tables, n, h)
    return wrong


@kernel
def are_on_pieces(tables: Tables, h: float, open_by: float) -> bool:
    """Whether every tendon is on the right segment at the present rates, which are those of the end."""
    for n in range(tables.tendon.shape[0]):
        c = tables.column.shape[0] + n
        after = segment_next(tables, n, h, along_arms(tables, n, tree.RATE), open_by)
        if tables.law[c, tree.BREAKS] > 0.0 and after != int(tables.law[c, tree.SEGMENT]):
            return False
    return True
