"""The places and bounds of shapes, and the test of all pairs that may touch: a broad phase for few, the oracle of the others.

Source: Ericson, Real-Time Collision Detection, sections 4.2 (axis-aligned boxes) and 7.1.
"""

import math
from typing import Annotated, NamedTuple

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec, load3, load4, load9, store3, store9
from plumbline.engine.maths.vec import add, mat_vec, norm, quat_mat, quat_mul
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved, floats_of, ints_of
from plumbline.engine.memory.tables import Shapes, shapes_of


class CollisionFilter(NamedTuple):
    """What decides whether two shapes may touch.

    Terms: kind: motion of bodies; shape_kind: owner and material of shapes; surface: law of each pair of materials; excluded:
    pairs of bodies that a joint keeps apart.
    """

    kind: Annotated[Ints, at.BODY_KIND]
    shape_kind: Annotated[Ints, at.SHAPE_KIND]
    surface: Annotated[Floats, at.SURFACE]
    materials: Annotated[int, at.MATERIALS]
    excluded: Annotated[Ints, at.EXCLUDED]
    exclusions: Annotated[int, at.EXCLUSIONS]


collision_filter_of = carved(CollisionFilter)


@inlined
def kept_apart(rules: CollisionFilter, i: int, j: int) -> bool:
    """Whether shapes i and j never touch: neither can move, or they belong to one body, or a joint or material parts them."""
    a, b = rules.shape_kind[i, at.OWNER], rules.shape_kind[j, at.OWNER]
    if a == b or (rules.kind[a, at.MOTION] != at.DYNAMIC and rules.kind[b, at.MOTION] != at.DYNAMIC):
        return True
    if rules.surface[rules.shape_kind[i, at.MATERIAL] * rules.materials + rules.shape_kind[j, at.MATERIAL], at.APART] == 1.0:
        return True
    for e in range(rules.exclusions):
        first, second = rules.excluded[e, 0], rules.excluded[e, 1]
        if (first == a and second == b) or (first == b and second == a):
            return True
    return False


BLOCK = 32
"""Shapes whose pairs stand together, sorted by how far behind the second shape comes, and then by the first.

Contacts that follow one another so move different bodies, and the processor works on several at once; those of a block are few
enough for their bodies to stay in the nearest cache. Which of two pairs comes first hangs on no other shape.
"""


@kernel
def put_pose(shape: Floats, s: int, p: Vec, q: Quat, pose: Floats, row: int) -> None:
    """Write position [m] and rotation matrix in W of shape s, of a body at p and turned by q."""
    store3(pose, row, 0, add(p, mat_vec(quat_mat(q), load3(shape, s, at.OFFSET))))
    store9(pose, row, 3, quat_mat(quat_mul(q, load4(shape, s, at.TURN))))


@kernel
def pose_shape(state: Floats, b: int, shapes: Shapes, s: int) -> None:
    """Write position and rotation matrix in W of shape s of body b."""
    offset = load3(shapes.shape, s, at.OFFSET)
    if shapes.kind[s, at.TYPE] == at.SPHERE and offset[0] == 0.0 and offset[1] == 0.0 and offset[2] == 0.0:
        # A ball about the centre of mass looks the same however it is turned: its matrix stays as it was at the start.
        store3(shapes.pose, s, 0, load3(state, b, at.P))
        return
    put_pose(shapes.shape, s, load3(state, b, at.P), load4(state, b, at.Q), shapes.pose, s)


@kernel
def bound_shape(state: Floats, b: int, shapes: Shapes, s: int, bounds: Floats, least: float, dt: float) -> None:
    """Write the axis-aligned bounds [m] of shape s of body b, widened by `least` [m] and by its way in dt, and by how much."""
    shape, pose, kind = shapes.shape, shapes.pose, shapes.kind[s, at.TYPE]
    grow = least + dt * norm(load3(state, b, at.V))
    if shape[s, at.BALL_RADIUS] < math.inf:
        swing = norm(load3(shape, s, at.OFFSET)) + (shape[s, at.BALL_RADIUS] if kind != at.SPHERE else 0.0)
        if swing > 0.0:
            grow += dt * norm(load3(state, b, at.W)) * swing
    m = load9(pose, s, 3)
    for k in range(3):
        if kind == at.PLANE:
            half = math.inf
        elif kind == at.SPHERE:
            half = shape[s, at.SIZE]
        elif kind == at.CAPSULE:
            half = shape[s, at.SIZE] + shape[s, at.SIZE + 1] * abs(m[3 * k + 2])
        elif kind == at.BOX or kind >= at.HULL:
            half = shape[s, at.SIZE] * abs(m[3 * k]) + shape[s, at.SIZE + 1] * abs(m[3 * k + 1])
            half += shape[s, at.SIZE + 2] * abs(m[3 * k + 2])
        elif kind == at.ELLIPSOID:
            one, two = shape[s, at.SIZE] * m[3 * k], shape[s, at.SIZE + 1] * m[3 * k + 1]
            three = shape[s, at.SIZE + 2] * m[3 * k + 2]
            half = math.sqrt(one * one + two * two + three * three)
        else:
            half = shape[s, at.BALL_RADIUS]
        bounds[s, k] = pose[s, k] - half - grow
        bounds[s, k + 3] = pose[s, k] + half + grow
    bounds[s, 6] = grow


@kernel
def is_placed(state: Floats, b: int, placed: Floats, least: float) -> bool:
    """Whether the shapes of body b are where they were placed last, and as wide; from now on they are."""
    same = placed[b, at.LEAST] == least
    placed[b, at.LEAST] = least
    for k in range(at.LEAST):
        same = same and placed[b, k] == state[b, k]
        placed[b, k] = state[b, k]
    return bool(same)


@kernel
def place_shapes(floats: Floats, ints: Ints) -> None:
    """Write place and bounds of every shape, but for those of static bodies that lie as they lay.

    Two shapes together are widened by no less than `look_ahead`, so that no contact depends on the bounds. Shapes of a body
    follow one another.
    """
    state, placed, kind = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.PLACED), ints_of(ints, at.BODY_KIND)
    shapes, bounds, setting = shapes_of(floats, ints), floats_of(floats, ints, at.BOUNDS), floats_of(floats, ints, at.SETTING)
    dt = setting[0, at.WHOLE_STEP]
    least = setting[0, at.MARGIN] + 0.5 * dt * dt * norm(load3(setting, 0, at.GRAVITY))
    last, lies = -1, False
    for s in range(ints_of(ints, at.COUNT)[0, at.SHAPES]):
        b = shapes.kind[s, at.OWNER]
        if b != last:
            static = kind[b, at.MOTION] == at.STATIC
            last, lies = b, static and is_placed(state, b, placed, least)
            if static and not lies:
                ints_of(ints, at.PROGRESS)[0, at.ANEW] = 1
        if not lies:
            pose_shape(state, b, shapes, s)
            bound_shape(state, b, shapes, s, bounds, least, dt)


@inlined
def boxes_overlap(bounds: Floats, i: int, j: int) -> bool:
    """Whether the bounds of shapes i and j overlap."""
    apart = False
    for k in range(3):
        apart = apart or bounds[i, k] > bounds[j, k + 3] or bounds[j, k] > bounds[i, k + 3]
    return not apart


@inlined
def reaches_plane(bounds: Floats, pose: Floats, plane: int, other: int) -> bool:
    """Whether the lowest corner of the bounds of a shape lies below a plane."""
    height = 0.0
    for k in range(3):
        n = pose[plane, 5 + 3 * k]
        height += n * ((bounds[other, k] if n > 0.0 else bounds[other, k + 3]) - pose[plane, k])
    return height <= 0.0


@inlined
def overlap(bounds: Floats, shape_kind: Ints, pose: Floats, i: int, j: int) -> bool:
    """Whether the bounds of shapes i and j overlap, or those of one reach the plane that the other is."""
    if shape_kind[i, at.TYPE] == at.PLANE or shape_kind[j, at.TYPE] == at.PLANE:
        if shape_kind[i, at.TYPE] == shape_kind[j, at.TYPE]:
            return False
        return reaches_plane(bounds, pose, i, j) if shape_kind[i, at.TYPE] == at.PLANE else reaches_plane(bounds, pose, j, i)
    return boxes_overlap(bounds, i, j)


@kernel
def brute_force(floats: Floats, ints: Ints) -> None:
    """Place the shapes, and write every overlapping pair, by i and then j > i. Their number may go beyond the room."""
    rules, pose = collision_filter_of(floats, ints), floats_of(floats, ints, at.POSE)
    bounds, pair = floats_of(floats, ints, at.BOUNDS), ints_of(ints, at.PAIR)
    shapes, pairs = ints_of(ints, at.COUNT)[0, at.SHAPES], 0
    place_shapes(floats, ints)
    for apart in range(1, shapes):
        for i in range(shapes - apart):
            j = i + apart
            if kept_apart(rules, i, j):
                continue
            if overlap(bounds, rules.shape_kind, pose, i, j):
                if pairs < pair.shape[0]:
                    pair[pairs, 0], pair[pairs, 1] = i, j
                pairs += 1
    ints_of(ints, at.COUNT)[0, at.PAIRS] = pairs
