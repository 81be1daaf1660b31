"""The tables of a world's trees, which lie behind those of its arena, with a directory of their own.

The last integer of a world's memory says where that directory begins; so a copy of both arrays is the full state still, and a
world without trees has none of it. A tree is the links that hang on each other by joints, parents before children; of each
link's joint there are as many degrees of freedom, "columns", as it leaves.
"""

from typing import Annotated, Final, NamedTuple

import numpy as np

from plumbline.engine.compile.jit import inlined
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved, table_within
from plumbline.engine.memory.tables import Bodies, Joints

# Links: what stays.
LINK: Final = 0
TURN: Final = 0  # 4: orientation of B in A at the start
TURNED_AXIS: Final = 4  # 4: (0, axis) times that: orientation(x) = cos(x/2) TURN + sin(x/2) TURNED_AXIS
ANCHOR_A: Final = 8  # 3, in A
ANCHOR_B: Final = 11  # 3, in B
AXIS: Final = 14  # 3, in A
START_X, MASS = 17, 18  # coordinate at the start
INERTIA: Final = 19  # 6, in B
LINEAR_DAMPING, ANGULAR_DAMPING = 25, 26
SHARE, SPIN_SHARE = 27, 28  # of momentum, and of angular momentum, that damping leaves over a sub-step
RATIO: Final = 29  # of a coordinate to that of the link that leads it; 1 where none does

# Links: how they move now. Spatial vectors are angular before linear, in W, about the tree's origin.
MOTION: Final = 1
ORIENTATION: Final = 0  # 4: q_WB
PLACE: Final = 4  # 3: of the centre of mass from the tree's origin
VELOCITY: Final = 7  # 6
BIAS: Final = 13  # 6: acceleration that velocities alone give against the parent
ORIGIN: Final = 19  # 3: of the tree in W, at its root alone
MATRIX: Final = 22  # 9: R_WB
BASE_VELOCITY: Final = 31  # 6: w_WB and v_WB of the base that a root was last seen on

# Links: articulated-body inertia, [[rotation, coupling], [coupling^T, translation]].
BODY: Final = 2
ROTATION: Final = 0  # 6
TRANSLATION: Final = 6  # 6
COUPLING: Final = 12  # 9

# Links: coordinates. A hinge or slide has its own first; ball and free joint an orientation; the free joint p_WB behind it.
COORDINATE: Final = 3
POSITION: Final = 4
POSE: Final = 7  # how many numbers these are, and where they stand again as they were at the start of a step

# Columns.
COLUMN: Final = 4
AXIS_W: Final = 0  # 6: motion along it at unit rate
PULL: Final = 6  # 6: articulated inertia times that
INVERSE: Final = 12  # of the inertia along it
RATE: Final = 13
ADDED: Final = 14  # to the inertia along it: rotor, implicit springs and dampers; inf where CHANGE is prescribed
PUSH, BESIDE = 15, 16  # force along it; that beside its law
MOMENTUM: Final = 17  # along it, of all that hangs on it
STARTED: Final = 18  # rate at the start of the sub-step
KEPT_RATE: Final = 19  # over the last sub-step, by which coordinates moved
KEPT_MOMENTUM, KEPT_CHANGE = 20, 21  # after it; of the kept rate, from the sub-step before it

# Laws of what acts along columns, then along tendons, a row each. Columns that are tied have one, that of the one that leads.
LAW: Final = 5
BREAK: Final = 0  # 8: rates at which its force jumps or bends, ascending
JUMPS: Final = 8  # 8: 1 where it jumps
BREAKS: Final = 16  # how many there are
LOWEST, HIGHEST = 17, 18  # rates; infinite where nothing bounds them
SEGMENT: Final = 19  # 2 i below break i, 2 i + 1 at it
X: Final = 20  # the coordinate
WHICH: Final = 21  # bits of HAS that act
HELD: Final = 22  # rate that a jump fixes
RULED: Final = 23  # 1 where the row is a law, and no part of that of a column that leads
ANSWERED: Final = 24  # the segment that it was on when the responses to contacts were written
SHARED: Final = 25  # ratio of the rate of its part to that of the column that leads
NEXT_PART: Final = 26  # row of the next part of the same law; -1 at the end
OWNER: Final = 27  # link
RULE: Final = 11  # so far behind their columns in JOINT stand the numbers of its joint, from LOWER to SPEED_LIMIT

# Links: what a sub-step makes of them. Velocities are of the centre of mass, in W.
PASSAGE: Final = 6
TURNING: Final = 0  # 4: from the orientation at the start to that at the end, in W
WAY: Final = 4  # 3: from the start to the end
ANCHOR_W: Final = 7  # 3: of the joint at the start, from the tree's origin
TURNED_INERTIA: Final = 10  # 6: in W at the start
BEND: Final = 16  # 6: w and v from the start to the end, less those along the tangent of the start
LAST_BEND, EARLIER_BEND = 22, 28  # 6 each: that of the last sub-step, and of the one before it
KEPT_SPIN: Final = 34  # 3: angular momentum that the last sub-step left; w without the gyroscopic effect
KEPT_VELOCITY: Final = 37  # 3: v from the start to the end of the last sub-step
PRESSURE: Final = 40  # 6: impulse of contacts over a sub-step, about the centre of mass, moment first
WHOLE_MOMENTUM, WHOLE_FORCE = 46, 52  # 6 each: of a link and all that hangs on it, about the tree's origin
KEPT_STRIDE: Final = 58  # step of Dormand-Prince, in the first row
CONTRACTION: Final = 59  # share of a change that a round leaves, as it is expected, in the first row

# Answers of links and of columns: to what acts now, and then to a unit force of each tie.
ANSWER: Final = 7
ACCELERATION, FORCE = 0, 6  # 6 each: of a link; that it needs, with all that hangs on it
ALONG: Final = 8
LEFT: Final = 0  # force along a column that is not taken up; the one that keeps its rate where it is at a jump
CHANGE: Final = 1  # of its rate, in a second

# Ties: the factor of what they do to each other, a row for each pair, and their forces. Tendons come last.
TIE_FACTOR: Final = 9
TIE: Final = 10
PULLED: Final = 0  # force along the coordinate that follows
SLACK: Final = 1  # 1 where no column can be moved, or its force is known
SOFTNESS: Final = 2  # of a tendon: of the length's acceleration by the force [1/kg]
AIM: Final = 3  # acceleration that a tendon aims at, or its force where that is known
KNOWN: Final = 4  # 1 where it is
HOLDS: Final = 5  # the force of a tendon over the sub-step so far

# Arms of tendons, a row for each column of the trees.
ARM: Final = 11

# Integers.
KIND: Final = 0
PARENT: Final = 0  # link, or -1 for the root of a tree
ROW: Final = 1  # body
JOINT: Final = 2  # -1 for a free root
TYPE: Final = 3  # of the joint, as JOINT_TYPE, or FREE
FIRST, COLUMNS = 4, 5  # column, and how many
BASE: Final = 6  # body that a root hangs on, the world's row included
ROOT: Final = 7  # link
LEADER: Final = 8  # link whose coordinate this one's follows; itself where none does
CLUSTER: Final = 9  # first link of the trees that ties hold together, and of those between them

OTHER: Final = 1  # bodies that no tree has and that are not static
CLOSING: Final = 2  # joints that close loops
FOLLOWER: Final = 3  # links that others lead, one for each tie

FREE: Final = 9

FLOAT_COLUMNS: Final = np.array([30, 37, 21, 2 * POSE, 22, 50, 60, 12, 2, 1, 6, 1])
INT_COLUMNS: Final = np.array([10, 1, 1, 1])


def float_view(floats: Floats, ints: Ints, k: int) -> Floats:
    """Table k of floats, (rows, columns), without a copy."""
    d = ints[len(ints) - 1] + 2 * k
    offset, rows, columns = ints[d], ints[d + 1], FLOAT_COLUMNS[k]
    return floats[offset : offset + rows * columns].reshape((rows, columns))


def int_view(ints: Ints, k: int) -> Ints:
    """Table k of integers, (rows, columns), without a copy."""
    d = ints[len(ints) - 1] + 2 * (len(FLOAT_COLUMNS) + k)
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
    d = ints[len(ints) - 1] + 2 * (len(FLOAT_COLUMNS) + k)
    table: Ints = table_within(ints, ints[d], ints[d + 1], INT_COLUMNS[k])
    return table


class Trees(NamedTuple):
    """The trees of a world: the tables of links, columns, laws, answers, ties and loops; and what of the world they move in.

    Terms: gyroscopic: 1 where the gyroscopic effect is on.
    """

    link: Annotated[Floats, floats_at, LINK]
    motion: Annotated[Floats, floats_at, MOTION]
    body: Annotated[Floats, floats_at, BODY]
    coordinate: Annotated[Floats, floats_at, COORDINATE]
    column: Annotated[Floats, floats_at, COLUMN]
    law: Annotated[Floats, floats_at, LAW]
    passage: Annotated[Floats, floats_at, PASSAGE]
    answer: Annotated[Floats, floats_at, ANSWER]
    along: Annotated[Floats, floats_at, ALONG]
    tie_factor: Annotated[Floats, floats_at, TIE_FACTOR]
    tie: Annotated[Floats, floats_at, TIE]
    arm: Annotated[Floats, floats_at, ARM]
    kind: Annotated[Ints, ints_at, KIND]
    other: Annotated[Ints, ints_at, OTHER]
    closing: Annotated[Ints, ints_at, CLOSING]
    follower: Annotated[Ints, ints_at, FOLLOWER]
    bodies: Bodies
    joints: Joints
    setting: Annotated[Floats, at.SETTING]
    gyroscopic: Annotated[int, at.GYROSCOPIC]


trees_of = carved(Trees)
