"""The layout of a world's memory.

One array of floats and one of integers are carved into tables. Passing two arrays to compiled code costs a fifth of a
microsecond; passing thirty costs more than a small step. The integer array starts with a directory of (offset, rows, columns)
for each table. A copy of both arrays is a world's full state, warm-start impulses included. Each table is declared with what
it has a row of and how many columns; what its columns hold stands below it, the first of several numbers with how many they
are.
"""

from typing import Final

import numpy as np

from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory.layout import FLOATS, INTS, Per, float_columns, int_columns

# What holds for the whole world.
SETTING: Final = float_columns(Per.WORLD, 24)
DT: Final = 0
GRAVITY: Final = 1  # 3
HERTZ, DAMPING_RATIO, MAX_PUSH = range(4, 7)
BOUNCE_SPEED: Final = 7  # below it there is no restitution; negative: chosen from the sub-step
MARGIN: Final = 8
STEP_TOLERANCE: Final = 9
WHOLE_STEP: Final = 10  # DT but while a swept step goes on in parts
LAST_SPAN: Final = 11  # time that the impulses at hand belong to
OPEN_GAP: Final = 12  # of the joint that a step found open [m or rad]

COUNT: Final = int_columns(Per.WORLD, 19)
BODIES, SHAPES, JOINTS, MANIFOLDS, OLD_MANIFOLDS = range(5)
SUBSTEPS, ITERATIONS, RELAXATIONS, RUNGE_KUTTA, GYROSCOPIC, CONTINUOUS = range(5, 11)
BROAD: Final = 11  # 0 brute force inside the step, 1 found before it
MATERIALS, EXCLUSIONS, STEPS = range(12, 15)
NEW: Final = 15  # manifolds of this step that the last one did not have
CONVEX_READY: Final = 16  # 1 where the convex narrow phase has answered the pairs of the coming step
PAIRS: Final = 17  # pairs of the coming step in PAIR
TOUCHED_BODIES: Final = 18  # in BODY_ORDER

SURFACE: Final = float_columns(Per.LAW, 6)  # the law's five numbers first
APART: Final = 5  # 1 where the materials never touch

EXCLUDED: Final = int_columns(Per.EXCLUDED, 2)

# Bodies.
STATE: Final = float_columns(Per.BODY, 13)  # the last row is the world itself
P: Final = 0  # 3: position
Q: Final = 3  # 4: orientation
V: Final = 7  # 3: velocity
W: Final = 10  # 3: angular velocity

BODY: Final = float_columns(Per.BODY, 18)
INV_MASS: Final = 0
MASS: Final = 1
INERTIA: Final = 2  # 6, in B
INV_INERTIA: Final = 8  # 6, in B
LINEAR_DAMPING: Final = 14
ANGULAR_DAMPING: Final = 15
ROUND: Final = 16  # 1 where the inertia is the same about every axis
EXTENT: Final = 17  # radius [m] about the centre of mass that holds all shapes

TURNED: Final = float_columns(Per.BODY, 6)  # inverse inertia in W
LOAD: Final = float_columns(Per.BODY, 6)  # applied force and torque in W

BODY_KIND: Final = int_columns(Per.BODY, 4)
MOTION: Final = 0  # 0 static, 1 kinematic, 2 dynamic
TOUCHED: Final = 1  # 1 where contacts or joints act in this step
STILL: Final = 2  # 1 where the body has hardly moved since its contacts were made
RING: Final = 3  # how many contacts the body is away from the next blow, as far as is asked; of one that stands, farther
STATIC, KINEMATIC, DYNAMIC = range(3)

BODY_ORDER: Final = int_columns(Per.BODY, 1)  # the touched bodies, ascending, or island by island

PRINCIPAL: Final = float_columns(Per.PRINCIPAL_BODY, 8)
MOMENTS: Final = 0  # 3, ascending
AXES: Final = 3  # 4: q_BP
STRIDE: Final = 7  # the adaptive integrator's next step [s], 0 before the first

START: Final = float_columns(Per.BODY, 13)  # state at the start of a stage
SLOPE: Final = float_columns(Per.BODY, 13)  # time derivative
TOTAL: Final = float_columns(Per.BODY, 13)  # weighted sum of derivatives
REST: Final = float_columns(Per.BODY, 7)  # pose since which a body counts as still

# Shapes.
SHAPE: Final = float_columns(Per.SHAPE, 12)
OFFSET: Final = 0  # 3, in B
TURN: Final = 3  # 4, in B
SIZE: Final = 7  # 3: radius | half extents or semi-axes | radius, half length
BALL_RADIUS: Final = 10  # of the bounding sphere; inf for a plane

SHAPE_KIND: Final = int_columns(Per.SHAPE, 4)
TYPE, OWNER, MATERIAL = range(3)
PART: Final = 3  # which of its body's shapes it is, or belongs to
SPHERE, CAPSULE, BOX, CYLINDER, ELLIPSOID, PLANE, HULL, TRIANGLE = range(8)

POSE: Final = float_columns(Per.SHAPE, 12)  # position and rotation matrix in W
BOUNDS: Final = float_columns(Per.SHAPE, 7)  # lower and upper corner, and by how much they are widened
PLACED: Final = float_columns(Per.BODY, 14)  # state that the shapes of a static body were placed with
LEAST: Final = 13  # by how much their bounds are widened [m]
FAT: Final = float_columns(Per.SHAPE, 6)  # widened bounds, which candidates were found for
ORDER: Final = int_columns(Per.SHAPE, 1)  # the sorted axis

POLYHEDRON: Final = int_columns(Per.SHAPE, 5)
FIRST_VERTEX, VERTICES, FIRST_FACE, FACES = range(4)
INNER: Final = 4  # bits of a triangle's edges that do not stick out

VERTEX: Final = float_columns(Per.VERTEX, 3)  # in S
FACE: Final = float_columns(Per.FACE, 3)  # outward normal in S
SPAN: Final = int_columns(Per.FACE, 2)  # first corner and number of corners in LOOP
LOOP: Final = int_columns(Per.FACE_CORNER, 1)  # row of VERTEX

# Pairs.
PAIR: Final = int_columns(Per.NEAR, 2)
CANDIDATE: Final = int_columns(Per.NEAR, 2)  # pairs whose widened bounds overlap

PROGRESS: Final = int_columns(Per.WORLD, 3)
CANDIDATES: Final = 0  # in CANDIDATE; -1 before the first search
AXIS: Final = 1  # along which the shapes are sorted
ANEW: Final = 2  # 1 where a shape of a static body was placed since the last search

HEAD: Final = int_columns(Per.SHAPE, 1)  # first old manifold of a shape
NEXT: Final = int_columns(Per.PAIR, 1)

# Joints.
JOINT: Final = float_columns(Per.JOINT, 40)
ANCHOR_A: Final = 0  # 3, in A
ANCHOR_B: Final = 3  # 3, in B
AXIS_A: Final = 6
AXIS_B: Final = 9
TURN_AB: Final = 12  # 4: orientation of B in A at the start
LENGTH, LOWER, UPPER = range(16, 19)
SPRING: Final = 19  # stiffness, damping, rest
DRIVE: Final = 22  # stiffness, damping, target, target velocity, limit
COORDINATE: Final = 27  # last value, to count full turns
POSITION: Final = 28  # the coordinate at the start
ARMATURE: Final = 29  # inertia of the rotor along the coordinate
ROTOR_RATE: Final = 30  # of the rotor, as the last sub-step left it
FRICTION_LOSS: Final = 31
REACTION: Final = 32  # 6: impulse and angular impulse on B about its anchor over the last step, in W
SPEED_LIMIT: Final = 38  # of the coordinate's rate, both ways

JOINT_ORDER: Final = int_columns(Per.JOINT, 1)  # joints as they stand, or island by island
JOINT_KIND: Final = int_columns(Per.JOINT, 6)
JOINT_TYPE, PARENT, CHILD = range(3)
HAS: Final = 3  # bits: 1 limits, 2 spring, 4 drive, 8 armature, 16 dry friction, 32 a limit of speed
IMPLICIT: Final = 4  # bits 2 and 4: too stiff for the explicit stages
FIXED, BALL, REVOLUTE, PRISMATIC, DISTANCE = range(5)
HAS_LIMITS: Final = 1
HAS_SPRING: Final = 2
HAS_DRIVE: Final = 4
HAS_ARMATURE: Final = 8
HAS_FRICTION: Final = 16
HAS_SPEED_LIMIT: Final = 32
HAS_TIED: Final = 64  # its coordinate, or one that it is tied to, has any of these

ROW: Final = float_columns(Per.ROW_OR_TRIAL, 18)  # one scalar constraint J v = ... between two bodies
JACOBIAN: Final = 0  # 12: linear and angular part of A, then of B
GAP: Final = 12  # violation of the position
CURVATURE: Final = 13  # dJ/dt v
SOFTNESS, BIAS, LOW, HIGH = range(14, 18)

ROW_BODY: Final = int_columns(Per.ROW_OR_TRIAL, 4)
JOINT_OF: Final = 2  # whose row it is
REACH: Final = float_columns(Per.ROW, 12)  # mass-weighted Jacobian
MATRIX: Final = float_columns(Per.ROW, Per.ROW)
FACTOR: Final = float_columns(Per.ROW, Per.ROW)

VECTOR: Final = float_columns(Per.VECTOR, Per.ROW)
IMPULSE, RIGHT, WORK, LOWEST, HIGHEST = range(5)
PIVOT: Final = 5  # 1 where the row is held: it has no equation of its own
BOUND: Final = 6  # -1 or 1 where a bound holds the row
ENVELOPE: Final = 7  # first column of the row's factor that may differ from 0
LOW_PART: Final = 8  # of impulses in double-double arithmetic
CAREFUL: Final = 9  # in front: 1 where floats do not carry the system and it is solved in double-double arithmetic

# Contacts.
MANIFOLD: Final = float_columns(Per.PAIR, 61)
NORMAL: Final = 0  # 3
LAW: Final = 3  # 5: static, kinetic, restitution, rolling, torsional
SPIN_IMPULSE: Final = 8  # 3: rolling and torsional impulse in W
SPIN_MASS: Final = 11  # rolling, torsional
TANGENTS: Final = 13  # 6: two unit vectors that make a right-handed frame with the normal
CENTRE_A: Final = 19  # 3, in W, from the centre of mass of A
CENTRE_B: Final = 22
NORMAL_BLOCK: Final = 25  # 6: inverse mass on (V3, W1, W2)
TANGENT_BLOCK: Final = 31  # 6: on (V1, V2, W3)
COUPLING: Final = 37  # 9: rows V1, V2, W3 by the forces of the other block
STOP_BLOCK: Final = 46  # 6: inverse of TANGENT_BLOCK, or of its part on (V1, V2) for points that give no moment
POINT_SHARE: Final = 53  # 1 / number of points
RIMS: Final = 54  # 1 where points roll on along the rim of a cylinder, 2 on an ellipsoid, else 0
RIM_AXIS_A: Final = 55  # 3, in A: of the cylinder that has such a rim
RIM_AXIS_B: Final = 58
STOP_TURN: Final = 52  # 1 / m2: of a moment to the friction at a metre from the centre

MANIFOLD_ORDER: Final = int_columns(Per.PAIR, 1)  # manifolds as they were found, or island by island
MANIFOLD_KEY: Final = int_columns(Per.PAIR, 9)
SHAPE_A, SHAPE_B, BODY_A, BODY_B, POINTS, SLIPS = range(6)
LEADS: Final = 6  # 0 if the points move with A, 1 if with B
STRIKES: Final = 7  # 1 if a point strikes in this sub-step
BEGUN: Final = 8  # the step whose search found it first
HURRIED: Final = int_columns(Per.PAIR, 1)  # as MANIFOLD_ORDER: those near a blow or a new contact, in this sub-step

SHARING: Final = int_columns(Per.PAIR, 1)  # as MANIFOLD_ORDER: those of bodies that share their load, in this step

POINT: Final = float_columns(Per.POINT, 36)
ARM_A: Final = 0  # 3, in W, from the centre of mass of A
ARM_B: Final = 3
SPOT_A: Final = 6  # 3, in A: material point on A
SPOT_B: Final = 9
SEPARATION: Final = 12  # of the point now
NORMAL_IMPULSE: Final = 13
TANGENT_IMPULSE: Final = 14  # 3, in W
NORMAL_MASS: Final = 17
TANGENT_MASS: Final = 18
APPROACH: Final = 19  # normal velocity at impact
STRUCK: Final = 20
SUM: Final = 21  # 3: impulse on B over the step
FIRST_GAP: Final = 24
SPIKE: Final = 25  # largest normal impulse of a sub-step in which the point strikes
PLACE: Final = 26  # 3: the point in W
ROUND_A: Final = 29  # radius [m] of a round surface: its touching point does not turn with the body; below 0: of a rim
ROUND_B: Final = 30
SPREAD: Final = 31  # 2: place about the manifold's centre along its tangents
HELD: Final = 33  # 2: friction impulse along the tangents
PUSH: Final = 35  # pseudo-impulse of the split position correction

POINT_KEY: Final = int_columns(Per.POINT, 2)
OLD_MANIFOLD: Final = float_columns(Per.PAIR, 61)
OLD_POINT: Final = float_columns(Per.OLD_POINT, 36)
OLD_KEY: Final = int_columns(Per.PAIR, 9)
OLD_POINT_KEY: Final = int_columns(Per.OLD_POINT, 2)
CLIP: Final = float_columns(Per.CLIP_POINT, 8)  # scratch of the clipping
CLIP_KEY: Final = int_columns(Per.CLIP_POINT, 2)
CONVEX_NORMAL: Final = float_columns(Per.CONVEX_PAIR, 3)  # of the pairs that the convex narrow phase answered
CONVEX_POINT: Final = float_columns(Per.CONVEX_POINT, 32)  # their points, as POINT
CONVEX_KEY: Final = int_columns(Per.CONVEX_PAIR, 1)  # number of points
CONVEX_POINT_KEY: Final = int_columns(Per.CONVEX_POINT, 2)
SIMPLEX: Final = float_columns(Per.SIMPLEX_CORNER, 10)  # scratch of GJK and EPA
SIMPLEX_KEY: Final = int_columns(Per.SIMPLEX_CORNER, 6)
POLYGON: Final = float_columns(Per.POLYGON_CORNER, 3)  # scratch of the clipping of features
POLYGON_KEY: Final = int_columns(Per.POLYGON_CORNER, 1)

# Contacts of worlds of spheres.
TOUCH: Final = float_columns(Per.TOUCH, 17)  # what the sphere solver sweeps over, the normal first
T_GAP: Final = 3
T_NORMAL: Final = 4  # normal impulse
T_TANGENT: Final = 5  # 3, in W
T_NORMAL_MASS: Final = 8
T_TANGENT_MASS: Final = 9
T_FRICTION: Final = 10  # the coefficient now in force
T_RADIUS_A: Final = 11
T_RADIUS_B: Final = 12  # 0 for a plane or a box
T_BASE: Final = 13  # of a plane or a box: n . p_A + gap, which stays
T_SUM: Final = 14  # 3: impulse on B over the step, but for its last sub-step's that stands yet

TOUCH_REST: Final = float_columns(Per.TOUCH, 15)  # what it needs less often
R_PLACE: Final = 0  # 3, in W
R_FIRST_GAP, R_STATIC, R_KINETIC, R_RESTITUTION = range(3, 7)
R_APPROACH: Final = 7  # 3, in W: velocity of B against A at impact
R_STRUCK: Final = 10
R_SPIKE: Final = 11
R_NORMAL: Final = 12  # 3: at the start of the step

TOUCH_KEY: Final = int_columns(Per.TOUCH, 6)
K_BODY_A: Final = 0
K_BODY_B: Final = 1
K_PAIR: Final = 2  # its rank among all pairs
K_SLIPS: Final = 3
K_ROUND: Final = 4  # 1 where B is a sphere too
K_MOVES: Final = 5  # 1 where B is dynamic

OLD_TOUCH: Final = float_columns(Per.TOUCH, 4)  # impulses of the last step
OLD_TOUCH_KEY: Final = int_columns(Per.TOUCH, 2)

MOVER: Final = float_columns(Per.MOVER, 8)  # velocity and angular velocity first
M_INV_MASS: Final = 6
M_INV_INERTIA: Final = 7

# Islands and sleep.
ISLAND: Final = int_columns(Per.MEMBER, 5)
ROOT: Final = 0  # parent in the forest of union-find
NUMBER: Final = 1  # of the body's island, -1 for bodies that do not move
ASLEEP: Final = 2  # 0 awake, else 1 + the lowest body of the island that fell asleep together
WAKES: Final = 3  # 1 at the lowest body of an island that is to wake
RESTLESS: Final = 4  # 1 for a static or kinematic body that moves

SPAN_OF_ISLAND: Final = int_columns(Per.SPAN, 9)
FIRST_BODY, FIRST_MANIFOLD, FIRST_JOINT, FIRST_ROW = range(4)  # in the orders of bodies, manifolds and joints, and in ROW
NEXT_FREE: Final = 4  # scratch: where the next of an order goes
HIT: Final = 5  # 1 if a point is about to strike, or, once solved, a surface with restitution was struck
UNEASY: Final = 6  # bodies that are not slow, or not for long
ROWS: Final = 7
EQUALITIES: Final = 8

COLOURED: Final = int_columns(Per.COLOURED, 4)
BAND: Final = 0  # of a pair, those of one colour numbered after each other
UNSORTED: Final = 1  # 2: a pair as it was found
FOLLOWING: Final = 3  # the next contact of the last step of the same sphere

COLOURS: Final = 2
MOST_BANDS: Final = 32  # of a colour
BANDS: Final = int_columns(Per.BAND, 2)
FIRST_IN_BAND: Final = 0  # of the contacts of a band
SLIPPING: Final = 1  # of a lane: whether a contact of its last sweep slips

BANDING: Final = float_columns(Per.BANDED_WORLD, 4)  # how the world is cut
BAND_AXIS, BAND_COUNT, BAND_START, BAND_WIDTH = range(4)

ANSWER: Final = float_columns(Per.ANSWERING_PAIR, 6)  # what a manifold gives in a sweep: force and moment, in its frame

LAST_OF_SPHERE: Final = int_columns(Per.COLOURED_MOVER, 1)  # a contact of the last step

CALM: Final = float_columns(Per.SLEEPER, 1)  # for how long [s] a body has been slow
REMEMBERED: Final = float_columns(Per.SLEEPER, 19)  # state and load of asleep and fixed bodies
RESTING_MANIFOLD: Final = float_columns(Per.RESTING_PAIR, 61)  # contacts of asleep islands
RESTING_POINT: Final = float_columns(Per.RESTING_POINT, 36)
RESTING_KEY: Final = int_columns(Per.RESTING_PAIR, 9)
RESTING_POINT_KEY: Final = int_columns(Per.RESTING_POINT, 2)

SLEEP: Final = float_columns(Per.WORLD, 2)
SLEEP_SPEED: Final = 0
SLEEP_TIME: Final = 1  # 0 where nothing sleeps

TALLY: Final = int_columns(Per.WORLD, 8)
ISLANDS: Final = 0
ELASTIC: Final = 1  # 1 if any manifold of this step has restitution
AROUSED: Final = 2  # new manifolds, over all searches of one step
RESTING: Final = 3  # manifolds of asleep islands
AWAKE: Final = 4  # dynamic bodies that are awake
RESTLESS_BODIES: Final = 5
THREADS: Final = 6
SEARCHED: Final = 7  # 1 where PAIR holds the pairs of the coming step, found before it

# Values of CONTINUOUS, in the order of the option's.
OFF, SPECULATIVE, SWEPT = range(3)

FLOAT_TABLES: Final = len(FLOATS)
INT_TABLES: Final = len(INTS)


def new_arena(shapes: Ints) -> tuple[Floats, Ints]:
    """Zeroed memory for tables of these shapes.

    Args: shapes (k, 2): rows and columns in the order of the table numbers, those of floats first.
    Returns: the array of floats, and the array of integers with the directory in front.
    """
    lengths, places = shapes.prod(axis=1), 3 * len(shapes)
    ends = np.concatenate((lengths[:FLOAT_TABLES].cumsum(), places + lengths[FLOAT_TABLES:].cumsum()))
    floats, ints = np.zeros(max(ends[FLOAT_TABLES - 1], 1)), np.zeros(ends[-1], np.int64)
    ints[:places] = np.column_stack((ends - lengths, shapes)).ravel()
    return floats, ints


def tables(floats: Floats, ints: Ints) -> tuple[list[Floats], list[Ints]]:
    """All tables of floats and of integers by their numbers, without a copy."""
    return [float_table(floats, ints, k) for k in range(FLOAT_TABLES)], [int_table(ints, k) for k in range(INT_TABLES)]


def float_table(floats: Floats, ints: Ints, k: int) -> Floats:
    """Table k of the floats, (rows, columns), without a copy."""
    offset, rows, columns = ints[3 * k], ints[3 * k + 1], ints[3 * k + 2]
    return floats[offset : offset + rows * columns].reshape((rows, columns))


def int_table(ints: Ints, k: int) -> Ints:
    """Table k of the integers, (rows, columns), without a copy."""
    d = 3 * (FLOAT_TABLES + k)
    offset, rows, columns = ints[d], ints[d + 1], ints[d + 2]
    return ints[offset : offset + rows * columns].reshape((rows, columns))
