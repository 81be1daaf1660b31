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

from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions
from plumbline.engine.articulated.articulated_body import accelerations, needed_by
from plumbline.engine.articulated.forces import weigh_links
from plumbline.engine.articulated.laws import ALL, PRESSED, is_ruled, next_segment, take_laws, take_segment, write_laws
from plumbline.engine.articulated.momenta import load_momenta, press_links
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.tendons import are_on_pieces, change_pieces, take_pieces
from plumbline.engine.articulated.ties import pulled_beside
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3
from plumbline.engine.maths.vec import add, dot, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

PATIENCE = 3
"""Rounds, after the best one, in which no fewer columns were on the wrong segment."""

ROUNDS: Final = 50
"""A column, after which there is no answer."""


@kernel
def needed_force(tables: Tables, i: int, armature: float) -> float:
    """The force of the law of the one column of link i that gives the change which is prescribed there."""
    k = tables.kind[i, tree.FIRST]
    a_w, a_v = load3(tables.motion, i, tree.ACCELERATION), load3(tables.motion, i, tree.ACCELERATION + 3)
    change = tables.column[k, tree.CHANGE]
    turning, sliding = load3(tables.column, k, tree.AXIS_W), load3(tables.column, k, tree.AXIS_W + 3)
    # The force has taken in what the change needs, so that the acceleration counts without it.
    a_w, a_v = add(a_w, scale(-change, turning)), add(a_v, scale(-change, sliding))
    torque, force = needed_by(tables.body, i, a_w, a_v)
    needed = dot(turning, torque) + dot(sliding, force) + armature * change - tables.column[k, tree.BESIDE]
    return float(needed - pulled_beside(tables, k))


@kernel
def held_by(tables: Tables, joints: Joints, i: int) -> float:
    """The force of the law of the column of link i that gives the changes which are prescribed there and in all that it leads.

    Of each of these columns the force along it alone is kept in LEFT.
    """
    kind, total, m = tables.kind, 0.0, i
    while m >= 0:
        force = needed_force(tables, m, joints.joint[kind[m, tree.JOINT], at.ARMATURE])
        tables.column[kind[m, tree.FIRST], tree.LEFT] = force
        total += tables.link[m, tree.RATIO] * force
        m = kind[m, tree.NEXT]
    return total


@kernel
def change_segments(tables: Tables, joints: Joints, h: float, alone: bool) -> int:
    """Let columns and tendons on the wrong segment go on to the next, all or the first alone. Returns: how many there were."""
    law, column, kind, wrong = tables.law, tables.column, tables.kind, 0
    for i in range(kind.shape[0]):
        k = kind[i, tree.FIRST]
        if not is_ruled(tables, joints, i) or law[k, tree.BREAKS] == 0.0:
            continue
        if int(law[k, tree.SEGMENT]) % 2 == 1:
            found = held_by(tables, joints, i)
        else:
            found = column[k, tree.RATE] + h * column[k, tree.CHANGE]
        segment = next_segment(tables, i, joints, h, found, 0.0)
        if segment != int(law[k, tree.SEGMENT]):
            wrong += 1
            if wrong == 1 or not alone:
                law[k, tree.SEGMENT] = segment
                take_segment(tables, i, joints, h)
    return change_pieces(tables, h, wrong, alone)


@kernel
def answer_laws(tables: Tables, bodies: Bodies, setting: Floats, h: float, gyroscopic: int, which: int) -> None:
    """Write the change of every column's rate over h with each on its segment. Args: as `solve_laws`."""
    if which <= ALL:
        load_momenta(tables, bodies, setting, h, gyroscopic)
        if which == PRESSED:
            press_links(tables, h)
    else:
        weigh_links(tables)
    accelerations(tables, False)


@kernel
def solve_laws(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, which: int) -> bool:
    """Write the change of every column's rate over h under the laws that act: ALL from the momenta that are kept, PRESSED
    from these and what contacts give, others under what pushes along columns alone.

    Returns: whether there is an answer.
    """
    breaks = write_laws(tables, joints, h, which)
    return settle_laws(tables, bodies, joints, setting, h, gyroscopic, which, breaks)


@kernel
def settle_laws(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, which: int, breaks: int
) -> bool:
    """As `solve_laws`, of laws that are written and have so many breaks."""
    fewest, patience = tables.column.shape[0] + 1, PATIENCE
    for _ in range(ROUNDS * (tables.column.shape[0] + 1)):
        answer_laws(tables, bodies, setting, h, gyroscopic, which)
        if breaks == 0:
            return True
        wrong = change_segments(tables, joints, h, patience == 0)
        if wrong == 0:
            return True
        if patience > 0:
            patience = PATIENCE if wrong < fewest else patience - 1
            fewest = min(fewest, wrong)
    return False


MOST_TURNS: Final = 50
"""By the contraction above these are beyond what rounding tells for c up to a fifth; a step that needs more is far too long."""

KNOWN = 0.1
"""Of the tolerance of a step, how exactly the rounds that close bends leave the rates, as a share of the largest one."""


@kernel
def start_laws(tables: Tables) -> None:
    """Note the rates at the start of a sub-step, before its laws are written."""
    for k in range(tables.column.shape[0]):
        tables.stage_rate[k, tree.STARTED] = tables.column[k, tree.RATE]
        tables.column[k, tree.BESIDE] = 0.0


@kernel
def held_with(tables: Tables, joints: Joints, i: int) -> tuple[float, float]:
    """The force that holds the column of link i, with all that it leads, at its jump, and the inertia along all of them."""
    column, kind, force, inertia, m = tables.column, tables.kind, 0.0, 0.0, i
    while m >= 0:
        k, ratio = kind[m, tree.FIRST], tables.link[m, tree.RATIO]
        own = joints.joint[kind[m, tree.JOINT], at.ARMATURE]
        for c in range(6):
            own += column[k, tree.AXIS_W + c] * column[k, tree.PULL + c]
        force, inertia = force + ratio * column[k, tree.LEFT], inertia + ratio * ratio * own
        m = kind[m, tree.NEXT]
    return force, inertia


@kernel
def are_settled(tables: Tables, joints: Joints, setting: Floats, h: float) -> bool:
    """Whether every column is on the right segment at its present rate and, at a jump, under the force that this takes."""
    law, column, kind, fastest = tables.law, tables.column, tables.kind, 0.0
    for k in range(column.shape[0]):
        fastest = max(fastest, abs(column[k, tree.RATE]))
    for i in range(kind.shape[0]):
        k = kind[i, tree.FIRST]
        if not is_ruled(tables, joints, i) or law[k, tree.BREAKS] == 0.0:
            continue
        found, open_by = column[k, tree.RATE], KNOWN * setting[0, at.STEP_TOLERANCE] * fastest
        if int(law[k, tree.SEGMENT]) % 2 == 1:
            found, inertia = held_with(tables, joints, i)
            open_by = open_by * inertia / h
        if next_segment(tables, i, joints, h, found, open_by) != int(law[k, tree.SEGMENT]):
            return False
    return are_on_pieces(tables, h, KNOWN * setting[0, at.STEP_TOLERANCE] * fastest)


@kernel
def start_again(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int, which: int, reactions: bool
) -> None:
    """Let laws be settled from the rates at hand on, as for the whole sub-step, and take back what joints carried over it.

    The momenta of links are counted from the last sub-step on in any case, those of rotors from the rates at its start.
    """
    column, kind = tables.column, tables.kind
    for i in range(kind.shape[0]):
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.BESIDE] = (
                joints.joint[j, at.ARMATURE] * (tables.stage_rate[k, tree.STARTED] - column[k, tree.RATE]) / h
            )
    take_laws(tables, joints, h)
    take_pieces(tables, h)
    if reactions:
        # With all on their segments, nothing changes and the joints carry what was counted.
        answer_laws(tables, bodies, setting, h, gyroscopic, which)
        add_reactions(tables, joints, -h)
