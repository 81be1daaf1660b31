"""The layout of a world's memory: one array of floats and one of integers, carved into tables.

Passing two arrays to compiled code costs a fifth of a microsecond; passing thirty costs more than a small step. The integer
array starts with a directory of (offset, rows, columns) for each table. A copy of both arrays is a world's full state,
warm-start impulses included.
"""

from typing import Final

import numpy as np

from engine.maths.vec import Floats, Ints

__all__ = ["float_table", "int_table", "new_arena"]

# Tables of floats.
STATE: Final = 0  # (bodies + 1, 13): the last row is the world itself
BODY: Final = 1  # (bodies + 1, 18)
TURNED: Final = 2  # (bodies + 1, 6): inverse inertia in W
LOAD: Final = 3  # (bodies + 1, 6): applied force and torque in W
START: Final = 4  # (bodies + 1, 13): state at the start of a stage
SLOPE: Final = 5  # (bodies + 1, 13): time derivative
TOTAL: Final = 6  # (bodies + 1, 13): weighted sum of derivatives
SHAPE: Final = 7  # (shapes, 12)
POSE: Final = 8  # (shapes, 12): position and rotation matrix in W
BOUNDS: Final = 9  # (shapes, 7): lower and upper corner, and by how much they are widened
JOINT: Final = 10  # (joints, 40)
ROW: Final = 11  # (rows, 18)
REACH: Final = 12  # (rows, 12): mass-weighted Jacobian
MATRIX: Final = 13  # (rows, rows)
FACTOR: Final = 14  # (rows, rows)
VECTOR: Final = 15  # (10, rows)
MANIFOLD: Final = 16  # (pairs, 61)
POINT: Final = 17  # (4 pairs, 36)
OLD_MANIFOLD: Final = 18
OLD_POINT: Final = 19
SURFACE: Final = 20  # (materials^2, 6): the law's five numbers, and 1 where the materials never touch
SETTING: Final = 21  # (1, 24)
CLIP: Final = 22  # (32, 8): scratch of the clipping
VERTEX: Final = 23  # (corners of all polyhedra, 3), in S
FACE: Final = 24  # (faces of all polyhedra, 3): outward normal in S
CONVEX_NORMAL: Final = 25  # (pairs, 3): of the pairs that the convex narrow phase answered
CONVEX_POINT: Final = 26  # (4 pairs, 32): their points, as POINT
SIMPLEX: Final = 27  # (corners and faces, 10): scratch of GJK and EPA
POLYGON: Final = 28  # (three polygons, 3): scratch of the clipping of features
PRINCIPAL: Final = 29  # (bodies + 1, 8) where the integrator turns bodies about their principal axes, or no rows
FAT: Final = 30  # (shapes, 6): widened bounds, which candidates were found for
TOUCH: Final = 31  # (pairs of spheres, 16): what the sphere solver sweeps over
TOUCH_REST: Final = 32  # (pairs of spheres, 18): what it needs less often
OLD_TOUCH: Final = 33  # (pairs of spheres, 4): impulses of the last step
MOVER: Final = 34  # (bodies + 1, 8): what the sphere solver reads and writes of a body
REST: Final = 35  # (bodies + 1, 7): pose since which a body counts as still
LOCAL_STATE: Final = 36  # (locals, 13): the bodies of every island beside each other, fixed ones once for each island
LOCAL_BODY: Final = 37  # (locals, 18)
LOCAL_TURNED: Final = 38  # (locals, 6)
LOCAL_LOAD: Final = 39  # (locals, 6)
LOCAL_JOINT: Final = 40  # (joints, 40)
CALM: Final = 41  # (bodies + 1, 1): for how long [s] a body has been slow
REMEMBERED: Final = 42  # (bodies + 1, 19): state and load of asleep and fixed bodies, to notice a change from outside
RESTING_MANIFOLD: Final = 43  # (pairs, 61): contacts of asleep islands
RESTING_POINT: Final = 44  # (4 pairs, 36)
SLEEP: Final = 45  # (1, 2)
FLOAT_TABLES: Final = 46

# Tables of integers.
BODY_KIND: Final = 0  # (bodies + 1, 4)
SHAPE_KIND: Final = 1  # (shapes, 4)
JOINT_KIND: Final = 2  # (joints, 6)
ROW_BODY: Final = 3  # (rows, 4)
PAIR: Final = 4  # (pairs, 2)
MANIFOLD_KEY: Final = 5  # (pairs, 8)
POINT_KEY: Final = 6  # (4 pairs, 2)
OLD_KEY: Final = 7
OLD_POINT_KEY: Final = 8
HEAD: Final = 9  # (shapes, 1): first old manifold of a shape
NEXT: Final = 10  # (pairs, 1)
ORDER: Final = 11  # (shapes, 1): the sorted axis
EXCLUDED: Final = 12  # (excluded pairs of bodies, 2)
COUNT: Final = 13  # (1, 18)
CLIP_KEY: Final = 14  # (32, 2)
POLYHEDRON: Final = 15  # (shapes, 5)
SPAN: Final = 16  # (faces, 2): first corner and number of corners in LOOP
LOOP: Final = 17  # (corners of all faces, 1): row of VERTEX
CONVEX_KEY: Final = 18  # (pairs, 1): number of points
CONVEX_POINT_KEY: Final = 19  # (4 pairs, 2)
SIMPLEX_KEY: Final = 20  # (corners and faces, 6)
POLYGON_KEY: Final = 21  # (three polygons, 1)
CANDIDATE: Final = 22  # (pairs, 2): pairs whose widened bounds overlap
TOUCH_KEY: Final = 23  # (pairs of spheres, 6)
OLD_TOUCH_KEY: Final = 24  # (pairs of spheres, 2)
PROGRESS: Final = 25  # (1, 2)
ISLAND: Final = 26  # (bodies + 1, 8) where islands are wanted, or no rows
SPAN_OF_ISLAND: Final = 27  # (bodies + 2, 10): where each island begins in the lists below
GROUPED: Final = 28  # (pairs, 1): manifolds, island by island
GROUPED_JOINT: Final = 29  # (joints, 1)
LOCAL_KIND: Final = 30  # (locals, 4)
LOCAL_OWNER: Final = 31  # (locals, 1): body
LOCAL_JOINT_KIND: Final = 32  # (joints, 6)
RESTING_KEY: Final = 33  # (pairs, 8)
RESTING_POINT_KEY: Final = 34  # (4 pairs, 2)
TALLY: Final = 35  # (1, 8)
INT_TABLES: Final = 36

# Columns of POLYHEDRON.
FIRST_VERTEX: Final = 0
VERTICES: Final = 1
FIRST_FACE: Final = 2
FACES: Final = 3
INNER: Final = 4  # bits of a triangle's edges that do not stick out

# Columns of STATE: position, orientation, velocity, angular velocity.
P: Final = 0
Q: Final = 3
V: Final = 7
W: Final = 10

# Columns of BODY.
INV_MASS: Final = 0
MASS: Final = 1
INERTIA: Final = 2  # 6, in B
INV_INERTIA: Final = 8  # 6, in B
LINEAR_DAMPING: Final = 14
ANGULAR_DAMPING: Final = 15
ROUND: Final = 16  # 1 where the inertia is the same about every axis
EXTENT: Final = 17  # radius [m] about the centre of mass that holds all shapes

# Columns of PRINCIPAL.
MOMENTS: Final = 0  # 3, ascending
AXES: Final = 3  # 4: q_BP
STRIDE: Final = 7  # the adaptive integrator's next step [s], 0 before the first

# Columns of BODY_KIND.
MOTION: Final = 0  # 0 static, 1 kinematic, 2 dynamic
TOUCHED: Final = 1  # 1 where contacts or joints act in this step
STILL: Final = 2  # 1 where the body has hardly moved since its contacts were made
STATIC: Final = 0
KINEMATIC: Final = 1
DYNAMIC: Final = 2

# Columns of ISLAND.
ROOT: Final = 0  # parent in the forest of union-find
NUMBER: Final = 1  # of the body's island, -1 for bodies that do not move
MEMBER: Final = 2  # not of this body: the touched bodies, island by island
STAMP: Final = 3  # scratch
LOCAL: Final = 4  # row of the body in the island that was written last
ASLEEP: Final = 5  # 0 awake, else 1 + the lowest body of the island that fell asleep together
WAKES: Final = 6  # 1 at the lowest body of an island that is to wake
RESTLESS: Final = 7  # 1 for a static or kinematic body that moves

# Columns of SPAN_OF_ISLAND, beside STAMP.
FIRST_BODY: Final = 0
FIRST_MANIFOLD: Final = 1
FIRST_JOINT: Final = 2
FIRST_LOCAL: Final = 4
FIRST_ROW: Final = 5
HIT: Final = 6  # 1 if a point is about to strike, or, once solved, a surface with restitution was struck
UNEASY: Final = 7  # bodies that are not slow, or not for long
ROWS: Final = 8
EQUALITIES: Final = 9

# Columns of SLEEP.
SLEEP_SPEED: Final = 0
SLEEP_TIME: Final = 1  # 0 where nothing sleeps

# Columns of TALLY.
ISLANDS: Final = 0
ELASTIC: Final = 1  # 1 if any manifold of this step has restitution
AROUSED: Final = 2  # new manifolds, over all searches of one step
RESTING: Final = 3  # manifolds of asleep islands
AWAKE: Final = 4  # dynamic bodies that are awake
RESTLESS_BODIES: Final = 5
THREADS: Final = 6
SEARCHED: Final = 7  # 1 where PAIR holds the pairs of the coming step, found before it

# Columns of SHAPE.
OFFSET: Final = 0  # 3, in B
TURN: Final = 3  # 4, in B
SIZE: Final = 7  # 3: radius | half extents | radius, half length
BALL_RADIUS: Final = 10  # of the bounding sphere; inf for a plane

# Columns of SHAPE_KIND.
TYPE: Final = 0
OWNER: Final = 1
MATERIAL: Final = 2
PART: Final = 3  # which of its body's shapes it is, or belongs to
SPHERE: Final = 0
CAPSULE: Final = 1
BOX: Final = 2
CYLINDER: Final = 3
PLANE: Final = 4
HULL: Final = 5
TRIANGLE: Final = 6

# Columns of JOINT.
ANCHOR_A: Final = 0  # 3, in A
ANCHOR_B: Final = 3  # 3, in B
AXIS_A: Final = 6
AXIS_B: Final = 9
TURN_AB: Final = 12  # 4: orientation of B in A at the start
LENGTH: Final = 16
LOWER: Final = 17
UPPER: Final = 18
SPRING: Final = 19  # stiffness, damping, rest
DRIVE: Final = 22  # stiffness, damping, target, target velocity, limit
COORDINATE: Final = 27  # last value, to count full turns
POSITION: Final = 28  # the coordinate at the start

# Columns of JOINT_KIND.
JOINT_TYPE: Final = 0
PARENT: Final = 1
CHILD: Final = 2
HAS: Final = 3  # bits: 1 limits, 2 spring, 4 drive
IMPLICIT: Final = 4  # bits 2 and 4: too stiff for the explicit stages
FIXED: Final = 0
BALL: Final = 1
REVOLUTE: Final = 2
PRISMATIC: Final = 3
DISTANCE: Final = 4
HAS_LIMITS: Final = 1
HAS_SPRING: Final = 2
HAS_DRIVE: Final = 4

# Columns of ROW: one scalar constraint J v = ... between two bodies.
JACOBIAN: Final = 0  # 12: linear and angular part of A, then of B
GAP: Final = 12  # violation of the position
CURVATURE: Final = 13  # dJ/dt v
SOFTNESS: Final = 14
BIAS: Final = 15
LOW: Final = 16
HIGH: Final = 17

# Rows of VECTOR.
IMPULSE: Final = 0
RIGHT: Final = 1
WORK: Final = 2
LOWEST: Final = 3
HIGHEST: Final = 4
PIVOT: Final = 5  # 1 where the row is held: it has no equation of its own
BOUND: Final = 6  # -1 or 1 where a bound holds the row
ENVELOPE: Final = 7  # first column of the row's factor that may differ from 0
LOW_PART: Final = 8  # of impulses in double-double arithmetic
CAREFUL: Final = 9  # in front: 1 where floats do not carry the system and it is solved in double-double arithmetic

# Columns of MANIFOLD.
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
RIMS: Final = 54  # 1 where points roll on along the rim of a cylinder, else 0
RIM_AXIS_A: Final = 55  # 3, in A: of the cylinder that has such a rim
RIM_AXIS_B: Final = 58
STOP_TURN: Final = 52  # 1 / m2: of a moment to the friction at a metre from the centre

# Columns of MANIFOLD_KEY.
SHAPE_A: Final = 0
SHAPE_B: Final = 1
BODY_A: Final = 2
BODY_B: Final = 3
POINTS: Final = 4
SLIPS: Final = 5
LEADS: Final = 6  # 0 if the points move with A, 1 if with B
STRIKES: Final = 7  # 1 if a point strikes in this sub-step

# Columns of POINT.
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

# Columns of SURFACE beside the law's.
APART: Final = 5

# Columns of SETTING.
DT: Final = 0
GRAVITY: Final = 1  # 3
HERTZ: Final = 4
DAMPING_RATIO: Final = 5
MAX_PUSH: Final = 6
BOUNCE_SPEED: Final = 7  # below it there is no restitution; negative: chosen from the sub-step
MARGIN: Final = 8
STEP_TOLERANCE: Final = 9
WHOLE_STEP: Final = 10  # DT but while a swept step goes on in parts
LAST_SPAN: Final = 11  # time that the impulses at hand belong to
OPEN_GAP: Final = 12  # of the joint that a step found open [m or rad]

# Columns of COUNT.
BODIES: Final = 0
SHAPES: Final = 1
JOINTS: Final = 2
MANIFOLDS: Final = 3
OLD_MANIFOLDS: Final = 4
SUBSTEPS: Final = 5
ITERATIONS: Final = 6
RELAXATIONS: Final = 7
RUNGE_KUTTA: Final = 8
GYROSCOPIC: Final = 9
CONTINUOUS: Final = 10
BROAD: Final = 11  # 0 brute force inside the step, 1 found before it
MATERIALS: Final = 12
EXCLUSIONS: Final = 13
STEPS: Final = 14
NEW: Final = 15  # manifolds of this step that the last one did not have
CONVEX_READY: Final = 16  # 1 where the convex narrow phase has answered the pairs of the coming step
PAIRS: Final = 17  # pairs of the coming step in PAIR

# Columns of PROGRESS.
CANDIDATES: Final = 0  # in CANDIDATE; -1 before the first search
AXIS: Final = 1  # along which the shapes are sorted

# Columns of TOUCH, after the normal.
T_GAP: Final = 3
T_NORMAL: Final = 4  # normal impulse
T_TANGENT: Final = 5  # 3, in W
T_NORMAL_MASS: Final = 8
T_TANGENT_MASS: Final = 9
T_FRICTION: Final = 10  # the coefficient now in force
T_RADIUS_A: Final = 11
T_RADIUS_B: Final = 12  # 0 for a plane or a box
T_BASE: Final = 13  # of a plane or a box: n . p_A + gap, which stays

# Columns of TOUCH_REST.
R_PLACE: Final = 0  # 3, in W
R_FIRST_GAP: Final = 3
R_SUM: Final = 4  # 3: impulse on B over the step
R_STATIC: Final = 7
R_KINETIC: Final = 8
R_RESTITUTION: Final = 9
R_APPROACH: Final = 10  # 3, in W: velocity of B against A at impact
R_STRUCK: Final = 13
R_SPIKE: Final = 14
R_NORMAL: Final = 15  # 3: at the start of the step

# Columns of TOUCH_KEY.
K_BODY_A: Final = 0
K_BODY_B: Final = 1
K_PAIR: Final = 2  # first shape times the number of shapes, plus second
K_SLIPS: Final = 3
K_ROUND: Final = 4  # 1 where B is a sphere too
K_MOVES: Final = 5  # 1 where B is dynamic

# Columns of MOVER: velocity and angular velocity first.
M_INV_MASS: Final = 6
M_INV_INERTIA: Final = 7

# What a step returns beside the number of steps done, from this number on: which joint stays open.
OPEN_JOINT: Final = 16

# Values of CONTINUOUS, in the order of the option's.
OFF: Final = 0
SPECULATIVE: Final = 1
SWEPT: Final = 2


def new_arena(float_shapes: list[tuple[int, int]], int_shapes: list[tuple[int, int]]) -> tuple[Floats, Ints]:
    """Zeroed memory for tables of these shapes.

    Args: float_shapes, int_shapes: (rows, columns) in the order of the table numbers.
    Returns: the array of floats, and the array of integers with the directory in front.
    """
    places = 3 * (FLOAT_TABLES + INT_TABLES)
    directory: list[int] = []
    at = 0
    for rows, columns in float_shapes:
        directory += [at, rows, columns]
        at += rows * columns
    floats = np.zeros(max(at, 1))
    at = places
    for rows, columns in int_shapes:
        directory += [at, rows, columns]
        at += rows * columns
    ints = np.zeros(at, np.int64)
    ints[:places] = directory
    return floats, ints


def float_table(floats: Floats, ints: Ints, k: int) -> Floats:
    """Table k of the floats, (rows, columns), without a copy."""
    at, rows, columns = ints[3 * k], ints[3 * k + 1], ints[3 * k + 2]
    return floats[at : at + rows * columns].reshape((rows, columns))


def int_table(ints: Ints, k: int) -> Ints:
    """Table k of the integers, (rows, columns), without a copy."""
    d = 3 * (FLOAT_TABLES + k)
    at, rows, columns = ints[d], ints[d + 1], ints[d + 2]
    return ints[at : at + rows * columns].reshape((rows, columns))
