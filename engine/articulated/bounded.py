"""Accelerations under the laws of all columns: solve with each on a segment, until every one is on the right one.

All columns on the wrong segment go on to the next at once, which takes one or two rounds; where that makes no progress, the
first of them alone, which comes to an end since the mobility of columns is positive definite.

Laws choose their segments under the bends that are expected, and the rounds that close these keep them. What the rounds change
may take a rate past a break, or the force at a jump past what the law has there. Then all laws are settled again from the rates
at hand, under the bends that these make, and the bends closed again, until every column is where its law says. With bends that
follow rates by a factor c of theirs, in the norm of the kinetic energy, each turn leaves at most 2 c / (1 - c) of the error:
both what settles laws and what closes bends there are projections, which lengthen nothing. c is about h times the angular
velocities, and the turns come to their end where it is below 1/3.

Source: Judice, Pires, A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems,
Computers Ops Res. 21, 1994; Cottle, Pang, Stone, The Linear Complementarity Problem, sections 4.2 (least index) and 5.2
(contractions); Rockafellar, Convex Analysis, 1970, section 31 (proximations).
"""

import math
from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions
from plumbline.engine.articulated.articulated_body import accelerations, needed_by
from plumbline.engine.articulated.forces import weigh_links
from plumbline.engine.articulated.laws import first_segment, middle, next_segment, piece, write_breaks
from plumbline.engine.articulated.momenta import load_momenta
from plumbline.engine.articulated.spatial import axpy6, dot6
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.articulated.tendons import along_law, length_of, row_of, take_piece
from plumbline.engine.articulated.ties import pulled_beside
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load6
from plumbline.engine.memory import arena as at

# Which laws act.
ALL: Final = 0
STIFF_ALONE: Final = 1
"""Limits, and springs and drives that are marked as too stiff for explicit stages."""
SMOOTH: Final = 2
"""Springs and drives."""

PATIENCE = 3
"""Rounds, after the best one, in which no fewer columns were on the wrong segment."""

ROUNDS: Final = 50
"""A column, after which there is no answer."""

MOST_TURNS: Final = 50
"""By the contraction above these are beyond what rounding tells for c up to a fifth; a step that needs more is far too long."""

KNOWN = 0.1
"""Of the tolerance of a step, how exactly the rounds that close bends leave the rates, as a share of the largest one."""


@kernel
def take_segment(trees: Trees, k: int, h: float) -> None:
    """Write what the segment of law k adds to the inertia and pushes by, or the change that a jump prescribes, of all its
    parts; of a tendon, what it pulls by."""
    law, column, segment = trees.law, trees.column, int(trees.law[k, tree.SEGMENT])
    if k >= column.shape[0]:
        take_piece(trees, k, h)
        return
    rate = law[k, tree.BREAK + segment // 2] if segment % 2 == 1 else middle(law, k, segment // 2, column[k, tree.RATE])
    c = k
    while c >= 0:
        own, law[c, tree.SEGMENT] = law[c, tree.SHARED] * rate, segment
        if segment % 2 == 1:
            law[c, tree.HELD], column[c, tree.ADDED] = own, math.inf
            trees.along[c, tree.CHANGE] = (own - column[c, tree.RATE]) / h
        else:
            push, slope = piece(law, c, h, own)
            column[c, tree.ADDED] = law[c, tree.RULE + at.ARMATURE] + h * slope
            column[c, tree.PUSH] = push - slope * column[c, tree.RATE] + column[c, tree.BESIDE]
        c = int(law[c, tree.NEXT_PART])


@kernel
def begin_law(trees: Trees, k: int, h: float) -> int:
    """Write the breaks of law k, and let it be on its first segment. Returns: how many there are."""
    law = trees.law
    write_breaks(law, k, h)
    law[k, tree.SEGMENT], law[k, tree.RULED] = first_segment(law, k, along_law(trees, k, trees.column, tree.RATE)), 1.0
    take_segment(trees, k, h)
    return int(law[k, tree.BREAKS])


@kernel
def write_laws(trees: Trees, h: float, which: int) -> int:
    """Write the laws of all columns and tendons for a sub-step h, each on its first segment. Returns: how many breaks."""
    law, kind, joints, breaks = trees.law, trees.kind, trees.joints, 0
    for i in range(kind.shape[0]):
        j, c = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            acting = -1 if which == ALL else joints.kind[j, at.IMPLICIT] | at.HAS_LIMITS
            if which == SMOOTH:
                acting = at.HAS_SPRING | at.HAS_DRIVE
            law[c, tree.WHICH], law[c, tree.X] = joints.kind[j, at.HAS] & acting, trees.coordinate[i, 0]
            for number in range(at.LOWER, at.SPEED_LIMIT + 1):
                law[c, tree.RULE + number] = joints.joint[j, number]
    for i in range(kind.shape[0]):
        j = kind[i, tree.JOINT]
        if j >= 0 and joints.kind[j, at.HAS] != 0 and kind[i, tree.LEADER] == i:
            breaks += begin_law(trees, kind[i, tree.FIRST], h)
    for k in range(trees.column.shape[0], law.shape[0]):
        law[k, tree.X] = length_of(trees, k - trees.column.shape[0])
        breaks += begin_law(trees, k, h)
    return breaks


@kernel
def take_laws(trees: Trees, h: float) -> None:
    """Write what the segments of all laws add and push anew, from the present rates on."""
    for k in range(trees.law.shape[0]):
        if trees.law[k, tree.RULED] == 1.0:
            take_segment(trees, k, h)


@kernel
def needed_force(trees: Trees, k: int) -> float:
    """The force of the law along column k that gives the change which is prescribed there."""
    i, change, axis = int(trees.law[k, tree.OWNER]), trees.along[k, tree.CHANGE], load6(trees.column, k, tree.AXIS_W)
    # The force has taken in what the change needs, so that the acceleration counts without it.
    force = needed_by(trees, i, axpy6(-change, axis, load6(trees.answer, i, tree.ACCELERATION)))
    needed = dot6(axis, force) + trees.law[k, tree.RULE + at.ARMATURE] * change - trees.column[k, tree.BESIDE]
    return float(needed - pulled_beside(trees, k))


@kernel
def write_needed_forces(trees: Trees) -> None:
    """Write into LEFT of every column whose change is prescribed the force along it that gives this."""
    for k in range(trees.column.shape[0]):
        if trees.column[k, tree.ADDED] == math.inf:
            trees.along[k, tree.LEFT] = needed_force(trees, k)


@kernel
def held_by(trees: Trees, k: int) -> tuple[float, float]:
    """The force that holds law k at its jump, with all its parts, and the inertia along all of them."""
    law, column, force, inertia, c = trees.law, trees.column, 0.0, 0.0, k
    if k >= column.shape[0]:
        row, rows = row_of(trees, k), trees.tie.shape[0]
        pivot = trees.tie_factor[rows * row + row, 0]
        return float(trees.tie[row, tree.HOLDS]), 1.0 / (pivot * pivot)
    while c >= 0:
        ratio = law[c, tree.SHARED]
        own = law[c, tree.RULE + at.ARMATURE] + dot6(load6(column, c, tree.AXIS_W), load6(column, c, tree.PULL))
        force, inertia = force + ratio * trees.along[c, tree.LEFT], inertia + ratio * ratio * own
        c = int(law[c, tree.NEXT_PART])
    return force, inertia


@kernel
def segment_after(trees: Trees, k: int, h: float, rate: float, open_by: float) -> int:
    """The segment that law k goes on to; the present one where it is right. Args: rate: at the end; open_by: known to that."""
    if int(trees.law[k, tree.SEGMENT]) % 2 == 0:
        return next_segment(trees.law, k, h, rate, open_by)
    force, inertia = held_by(trees, k)
    return next_segment(trees.law, k, h, force, open_by * inertia / h)


@kernel
def change_segments(trees: Trees, h: float, alone: bool) -> int:
    """Let laws on the wrong segment go on to the next, all or the first alone. Returns: how many there were."""
    law, wrong = trees.law, 0
    write_needed_forces(trees)
    for k in range(law.shape[0]):
        if law[k, tree.RULED] == 0.0 or law[k, tree.BREAKS] == 0.0:
            continue
        rate = along_law(trees, k, trees.column, tree.RATE) + h * along_law(trees, k, trees.along, tree.CHANGE)
        segment = segment_after(trees, k, h, rate, 0.0)
        if segment != int(law[k, tree.SEGMENT]):
            wrong += 1
            if wrong == 1 or not alone:
                law[k, tree.SEGMENT] = segment
                take_segment(trees, k, h)
    return wrong


@kernel
def answer_laws(trees: Trees, h: float, which: int) -> None:
    """Write the change of every column's rate over h with each on its segment. Args: as `solve_laws`."""
    if which == ALL:
        load_momenta(trees, h)
    else:
        weigh_links(trees)
    accelerations(trees, False)


@kernel
def solve_laws(trees: Trees, h: float, which: int) -> bool:
    """Write the change of every column's rate over h under the laws that act: ALL from the momenta that are kept and what
    contacts give, others under what pushes along columns alone.

    Returns: whether there is an answer.
    """
    return settle_laws(trees, h, which, write_laws(trees, h, which))


@kernel
def settle_laws(trees: Trees, h: float, which: int, breaks: int) -> bool:
    """As `solve_laws`, of laws that are written and have so many breaks."""
    fewest, patience = trees.column.shape[0] + 1, PATIENCE
    for _ in range(ROUNDS * (trees.column.shape[0] + 1)):
        answer_laws(trees, h, which)
        if breaks == 0:
            return True
        wrong = change_segments(trees, h, patience == 0)
        if wrong == 0:
            return True
        if patience > 0:
            patience = PATIENCE if wrong < fewest else patience - 1
            fewest = min(fewest, wrong)
    return False


@kernel
def start_laws(trees: Trees) -> None:
    """Note the rates at the start of a sub-step, before its laws are written."""
    for k in range(trees.column.shape[0]):
        trees.column[k, tree.STARTED], trees.column[k, tree.BESIDE] = trees.column[k, tree.RATE], 0.0


@kernel
def are_settled(trees: Trees, h: float) -> bool:
    """Whether every law is on the right segment at its present rate and, at a jump, under the force that this takes."""
    law, column, fastest = trees.law, trees.column, 0.0
    for k in range(column.shape[0]):
        fastest = max(fastest, abs(column[k, tree.RATE]))
    open_by = KNOWN * trees.setting[0, at.STEP_TOLERANCE] * fastest
    for k in range(law.shape[0]):
        if law[k, tree.RULED] == 1.0 and law[k, tree.BREAKS] > 0.0:
            segment = segment_after(trees, k, h, along_law(trees, k, column, tree.RATE), open_by)
            if segment != int(law[k, tree.SEGMENT]):
                return False
    return True


@kernel
def start_again(trees: Trees, h: float, reactions: bool) -> None:
    """Let laws be settled from the rates at hand on, as for the whole sub-step, and take back what joints carried over it.

    The momenta of links are counted from the last sub-step on in any case, those of rotors from the rates at its start.
    """
    column = trees.column
    for k in range(column.shape[0]):
        armature = trees.law[k, tree.RULE + at.ARMATURE]
        column[k, tree.BESIDE] = armature * (column[k, tree.STARTED] - column[k, tree.RATE]) / h
    take_laws(trees, h)
    if reactions:
        # With all on their segments, nothing changes and the joints carry what was counted.
        answer_laws(trees, h, ALL)
        add_reactions(trees, -h)
