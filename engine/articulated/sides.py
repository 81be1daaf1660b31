"""The segments of laws, once the bends are closed: whether columns are still on the right ones, and a new choice where not.

Laws choose their segments under the bends that are expected, and the rounds that close these keep them. What the rounds change
may take a rate past a break, or the force at a jump past what the law has there. Then all laws are settled again from the rates
at hand, under the bends that these make, and the bends closed again, until every column is where its law says. With bends that
follow rates by a factor c of theirs, in the norm of the kinetic energy, each turn leaves at most 2 c / (1 - c) of the error:
both what settles laws and what closes bends there are projections, which lengthen nothing. c is about h times the angular
velocities, and the turns come to their end where it is below 1/3.

Source: Cottle, Pang, Stone, The Linear Complementarity Problem, section 5.2 (contractions); Rockafellar, Convex Analysis, 1970,
section 31 (proximations).
"""

from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions
from plumbline.engine.articulated.bounded import answer_laws
from plumbline.engine.articulated.laws import is_ruled, next_segment, take_laws
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.tendons import are_on_pieces, take_pieces
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

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
