"""The tables of a world's trees, which lie behind those of its arena, with a directory of their own.

The last integer of a world's memory says where that directory begins; so a copy of both arrays is the full state still, and a
world without trees has none of it. A tree is the links that hang on each other by joints, parents before children; of each
link's joint there are as many degrees of freedom, "columns", as it leaves.
"""

from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory.carve import table_within

# Links: what stays.
LINK: Final = 0
TURN: Final = 0  # 4: orientation of B in A at the start
TURNED_AXIS: Final = 4  # 4: (0, axis) times that: orientation(x) = cos(x/2) TURN + sin(x/2) TURNED_AXIS
ANCHOR_A: Final = 8  # 3, in A
ANCHOR_B: Final = 11  # 3, in B
AXIS: Final = 14  # 3, in A
START_X: Final = 17  # coordinate at the start
MASS: Final = 18
INERTIA: Final = 19  # 6, in B
LINEAR_DAMPING: Final = 25
ANGULAR_DAMPING: Final = 26
SHARE: Final = 27  # of momentum that damping leaves over a sub-step
SPIN_SHARE: Final = 28  # of angular momentum
RATIO: Final = 29  # of a coordinate to that of the link that leads it; 1 where none does

# Links: how they move now. Spatial vectors are angular before linear, in W, about the tree's origin.
MOTION: Final = 1
ORIENTATION: Final = 0  # 4: q_WB
PLACE: Final = 4  # 3: of the centre of mass from the tree's origin
VELOCITY: Final = 7  # 6
BIAS: Final = 13  # 6: acceleration that velocities alone give against the parent
ACCELERATION: Final = 19  # 6
ORIGIN: Final = 25  # 3: of the tree in W, at its root alone
MATRIX: Final = 28  # 9: R_WB
BASE_VELOCITY: Final = 37  # 6: w_WB and v_WB of the base that a root was last seen on

# Links: articulated-body inertia, [[rotation, coupling], [coupling^T, translation]], and bias force.
BODY: Final = 2
ROTATION: Final = 0  # 6
TRANSLATION: Final = 6  # 6
COUPLING: Final = 12  # 9
FORCE: Final = 21  # 6

# Links: coordinates. A hinge or slide has its own first; ball and free joint an orientation; the free joint p_WB behind it.
COORDINATE: Final = 3
POSITION: Final = 4

# Columns.
COLUMN: Final = 4
AXIS_W: Final = 0  # 6: motion along it at unit rate
PULL: Final = 6  # 6: articulated inertia times that
INVERSE: Final = 12  # of the inertia along it
LEFT: Final = 13  # force along it that is not taken up; the one that keeps its rate where it is at a jump
RATE: Final = 14
CHANGE: Final = 15  # acceleration
ADDED: Final = 16  # to the inertia along it: rotor, implicit springs and dampers; inf where CHANGE is prescribed
PUSH: Final = 17  # force along it
BESIDE: Final = 18  # force along it beside its law
MOMENTUM: Final = 19  # along it, of all that hangs on it

# Columns: the law of what acts along one.
LAW: Final = 5
BREAK: Final = 0  # 8: rates at which its force jumps or bends, ascending
JUMPS: Final = 8  # 8: 1 where it jumps
BREAKS: Final = 16  # how many there are
LOWEST: Final = 17  # rate; -inf where nothing bounds it
HIGHEST: Final = 18
SEGMENT: Final = 19  # 2 i below break i, 2 i + 1 at it
X: Final = 20  # the coordinate
WHICH: Final = 21  # bits of HAS that act
HELD: Final = 22  # rate that a jump fixes

# Stages of Runge-Kutta: at the start, and the weighted sum of slopes; seven numbers each a link, one a column. The other
# integrators keep there what they hand on from one sub-step to the next.
STAGE: Final = 6
STAGE_RATE: Final = 7

PRESSURE: Final = 0  # 6, in STAGE: impulse that contacts give a link over a sub-step, about its centre of mass, force first
ANSWERED: Final = 0  # in STAGE_RATE: the segment that a column was on when the responses to contacts were written
STARTED: Final = 1  # in STAGE_RATE: the rate at the start of the sub-step

KEPT_RATE: Final = 0  # over the last sub-step, by which coordinates moved
KEPT_MOMENTUM: Final = 1  # after it
KEPT_CHANGE: Final = 2  # of the kept rate, from the sub-step before it

# Links: what a sub-step of semi-implicit Euler makes of them. Velocities are of the centre of mass, in W.
PASSAGE: Final = 8
TURNING: Final = 0  # 4: from the orientation at the start to that at the end, in W
WAY: Final = 4  # 3: from the start to the end
ANCHOR_W: Final = 7  # 3: of the joint at the start, from the tree's origin
TURNED_INERTIA: Final = 10  # 6: in W at the start
BEND: Final = 16  # 6: w and v from the start to the end, less those along the tangent of the start
LAST_BEND: Final = 22  # 6: that of the last sub-step
EARLIER_BEND: Final = 35  # 6: and of the one before it
KEPT_SPIN: Final = 28  # 3: angular momentum that the last sub-step left; w without the gyroscopic effect
KEPT_VELOCITY: Final = 31  # 3: v from the start to the end of the last sub-step
KEPT_STRIDE: Final = 34  # step of Dormand-Prince, in the first row
CONTRACTION: Final = 41  # share of a change that a round leaves, as it is expected, in the first row

# Links: what implicit midpoint sums up of a link and all that hangs on it, about the tree's origin, in the same table.
WHOLE_MOMENTUM: Final = 0  # 6
WHOLE_FORCE: Final = 6  # 6

# Ties: what a unit of a tie's force does to each link, and to each column; a row of each table more is room to work in.
TIE_LINK: Final = 9
TIE_ACCELERATION: Final = 0  # 6
TIE_FORCE: Final = 6  # 6
TIE_COLUMN: Final = 10
TIE_LEFT: Final = 0
TIE_CHANGE: Final = 1

# Ties: the factor of what they do to each other, a row for each pair, and their forces.
TIE_FACTOR: Final = 11
TIE: Final = 12
PULLED: Final = 0  # force along the coordinate that follows
SLACK: Final = 1  # 1 where no column can be moved, or its force is known
SOFTNESS: Final = 2  # of a tendon: of the length's acceleration by the force [1/kg]
AIM: Final = 3  # acceleration that a tendon aims at, or its force where that is known
KNOWN: Final = 4  # 1 where it is
HOLDS: Final = 5  # the force of a tendon over the sub-step so far
ON: Final = 6  # the segment that a tendon was on when the responses to contacts were written

# Tendons: their laws, in the columns of a joint; and their arms, a row for each column of the trees. As ties they come last.
TENDON: Final = 13
ARM: Final = 14

# Integers.
KIND: Final = 0
PARENT: Final = 0  # link, or -1 for the root of a tree
ROW: Final = 1  # body
JOINT: Final = 2  # -1 for a free root
TYPE: Final = 3  # of the joint, as JOINT_TYPE, or FREE
FIRST: Final = 4  # column
COLUMNS: Final = 5
BASE: Final = 6  # body that a root hangs on, the world's row included
ROOT: Final = 7  # link
LEADER: Final = 8  # link whose coordinate this one's follows; itself where none does
NEXT: Final = 9  # link that is led by the same, behind this one; -1 at the end
CLUSTER: Final = 10  # first link of the trees that ties hold together, and of those between them

OTHER: Final = 1  # bodies that no tree has and that are not static

CLOSING: Final = 2  # joints that close loops

FOLLOWER: Final = 3  # links that others lead, one for each tie

FREE: Final = 9

FLOAT_COLUMNS: Final = np.array([30, 43, 28, 8, 20, 23, 14, 3, 42, 12, 2, 1, 7, 40, 1])
INT_COLUMNS: Final = np.array([11, 1, 1, 1])
FLOAT_TABLES: Final = 15


class Tables(NamedTuple):
    """What is known of trees: of links what stays, moves, weighs; where they stand; columns, laws, stages; ties; loops."""

    link: Floats
    motion: Floats
    body: Floats
    coordinate: Floats
    column: Floats
    law: Floats
    stage: Floats
    stage_rate: Floats
    passage: Floats
    tie_link: Floats
    tie_column: Floats
    tie_factor: Floats
    tie: Floats
    tendon: Floats
    arm: Floats
    kind: Ints
    other: Ints
    closing: Ints
    follower: Ints


def float_view(floats: Floats, ints: Ints, k: int) -> Floats:
    """Table k of floats, (rows, columns), without a copy."""
    d = ints[len(ints) - 1] + 2 * k
    offset, rows, columns = ints[d], ints[d + 1], FLOAT_COLUMNS[k]
    return floats[offset : offset + rows * columns].reshape((rows, columns))


def int_view(ints: Ints, k: int) -> Ints:
    """Table k of integers, (rows, columns), without a copy."""
    d = ints[len(ints) - 1] + 2 * (FLOAT_TABLES + k)
    offset, rows, columns = ints[d], ints[d + 1], INT_COLUMNS[k]
    return ints[offset : offset + rows * columns].reshape((rows, columns))


@inlined
def floats_at(floats: Floats, ints: Ints, k: int) -> Floats:
    """As `float_view`, where compiled."""
    d = ints[len(ints) - 1] + 2 * k
    table: Floats = table_within(floats, ints[d], ints[d + 1], FLOAT_COLUMNS[k])
    return table


@inlined
def ints_at(ints: Ints, k: int) -> Ints:
    """As `int_view`, where compiled."""
    d = ints[len(ints) - 1] + 2 * (FLOAT_TABLES + k)
    table: Ints = table_within(ints, ints[d], ints[d + 1], INT_COLUMNS[k])
    return table


@inlined
def tables_of(floats: Floats, ints: Ints) -> Tables:
    """The tables of the trees of a world."""
    return Tables(
        floats_at(floats, ints, LINK),
        floats_at(floats, ints, MOTION),
        floats_at(floats, ints, BODY),
        floats_at(floats, ints, COORDINATE),
        floats_at(floats, ints, COLUMN),
        floats_at(floats, ints, LAW),
        floats_at(floats, ints, STAGE),
        floats_at(floats, ints, STAGE_RATE),
        floats_at(floats, ints, PASSAGE),
        floats_at(floats, ints, TIE_LINK),
        floats_at(floats, ints, TIE_COLUMN),
        floats_at(floats, ints, TIE_FACTOR),
        floats_at(floats, ints, TIE),
        floats_at(floats, ints, TENDON),
        floats_at(floats, ints, ARM),
        ints_at(ints, KIND),
        ints_at(ints, OTHER),
        ints_at(ints, CLOSING),
        ints_at(ints, FOLLOWER),
    )
