"""Write bodies, shapes, joints and surfaces into a new arena."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from plumbline.engine.build.joint_order import ROWS
from plumbline.engine.build.polyhedra import Polyhedron, closed_volume
from plumbline.engine.build.solids import body_solids, principal_frame, quat_mat, quat_mul
from plumbline.engine.describe.bodies import Body, Surface
from plumbline.engine.describe.check import finite, spd_inertia, unit_quaternion
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.joints import WORLD, Ball, Distance, Drive, Fixed, Joint, Limits, Prismatic, Revolute, Spring
from plumbline.engine.describe.shapes import Box, Plane, Sphere, TriangleMesh
from plumbline.engine.maths.arrays import dot, inverse, mat_mat, mat_vec, norm, unit
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.layout import FLOATS, INTS, Per, shapes_of
from plumbline.engine.options import COLOURED, CONTINUOUS, FREE_INTEGRATORS, GAUSS_SEIDEL, JACOBI, Options

MOTIONS = {"static": at.STATIC, "kinematic": at.KINEMATIC, "dynamic": at.DYNAMIC}
ENDLESS = 1e9
"""The extent [m] of a plane: where it turns at all, it does not count as still."""


def six(m: Floats) -> list[float]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric matrix."""
    return [m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2]]


def spheres_only(
    bodies: Sequence[Body], joints: Sequence[Joint], surfaces: Mapping[tuple[str, str], Surface], options: Options
) -> bool:
    """Whether the world is one that `engine.steps.spheres` serves."""
    if not options.contacts or options.sleeping or options.solver != "tgs_soft" or options.continuous == "swept":
        return False
    if options.sweeps == JACOBI:
        return False
    if joints or any(law.rolling_friction > 0 or law.torsional_friction > 0 for law in surfaces.values()):
        return False
    for body in bodies:
        if body.motion == "dynamic":
            inertia = np.asarray(body.inertia, float)
            single = len(body.shapes) == 1 and isinstance(body.shapes[0].shape, Sphere) and not np.any(body.shapes[0].p_BS)
            if body.shapes and not (single and np.array_equal(inertia, inertia[0, 0] * np.eye(3))):
                return False
        elif body.shapes and (
            body.motion != "static" or any(not isinstance(placed.shape, Sphere | Box | Plane) for placed in body.shapes)
        ):
            return False
    return True


def islands_know(options: Options) -> bool:
    """Whether islands are solved apart, and may sleep, under these options."""
    return options.solver == "tgs_soft" and options.continuous != "swept"


def wants_islands(bodies: Sequence[Body], joints: Sequence[Joint], options: Options) -> bool:
    """Whether islands are solved apart: to sleep, on threads, or because the joints hold more than one machine together.

    The direct solve of joints costs the cube of what is solved at once; the answer is the same to the last bit.
    """
    if not islands_know(options):
        return False
    if options.sweeps != GAUSS_SEIDEL:
        return False
    if options.threads > 1 or options.sleeping:
        return True
    above = {body.name: body.name for body in bodies if body.motion == "dynamic"}

    def root(name: str) -> str:
        while above[name] != name:
            above[name] = above[above[name]]
            name = above[name]
        return name

    held = [[name for name in (joint.parent, joint.child) if name in above] for joint in joints]
    for ends in held:
        for name in ends:
            above[root(name)] = root(ends[0])
    return len({root(name) for ends in held for name in ends}) > 1


def assemble_world(
    bodies: Sequence[Body], joints: Sequence[Joint], surfaces: Mapping[tuple[str, str], Surface], gravity: Sequence[float],
    options: Options, apart: Sequence[tuple[str, str]] = (), islands: bool = False,
) -> tuple[Floats, Ints]:  # fmt: skip
    """The arena of a world at its start, with room for islands where it has any. Raises: ValueError, NotSupported."""
    _check_pairs(surfaces, apart)
    n, nj = len(bodies), len(joints)
    index: dict[str, int] = {}
    known: set[str] = set()
    for joint in joints:
        if joint.name in known:
            raise ValueError(f"joint '{joint.name}': the name is taken")
        known.add(joint.name)
    for i, body in enumerate(bodies):
        if body.name in index or body.name == WORLD:
            raise ValueError(f"body '{body.name}': the name is taken")
        index[body.name] = i
    index[WORLD] = n
    for body in bodies:
        if moves_meshes(body):
            _check_closed(body)
    shapes = [(i, solid) for i, body in enumerate(bodies) for solid in body_solids(body)]
    ns = len(shapes)
    convex = any(solid.kind in (at.CYLINDER, at.ELLIPSOID, at.HULL, at.TRIANGLE) for _, solid in shapes)
    polyhedra = [(s, solid.polyhedron) for s, (_, solid) in enumerate(shapes) if convex and solid.polyhedron is not None]
    rows = sum(ROWS[type(joint)] + 3 + _along(joint) for joint in joints) + 1
    movable = sum(1 for i, _ in shapes if bodies[i].motion == "dynamic")
    near = min(ns * (ns - 1) // 2, 8 * movable + 16) if options.contacts else 0
    spheres = spheres_only(bodies, joints, surfaces, options)
    pairs, touches = (0, near) if spheres else (near, 0)
    materials = sorted({body.material for body in bodies} | {one for pair in (*surfaces, *apart) for one in pair})
    excluded = [
        (index[joint.parent], index[joint.child])
        for joint in joints
        if not joint.collide and joint.parent in index and joint.child in index
    ]
    sizes = {
        Per.WORLD: 1, Per.BODY: n + 1, Per.SHAPE: ns, Per.JOINT: nj, Per.ROW: rows, Per.ROW_OR_TRIAL: 2 * rows + 2,
        Per.VECTOR: at.CAREFUL + 1, Per.EXCLUDED: len(excluded), Per.LAW: len(materials) * len(materials), Per.CLIP_POINT: 32,
        Per.PRINCIPAL_BODY: n + 1 if options.integrator in FREE_INTEGRATORS else 0, Per.MOVER: n + 1 if spheres else 0,
        Per.NEAR: near, Per.PAIR: pairs, Per.POINT: 4 * pairs + 1, Per.OLD_POINT: 4 * pairs, Per.TOUCH: touches,
        **_sweep_sizes(n, near, options, spheres),
        **_convex_sizes([polyhedron for _, polyhedron in polyhedra], pairs if convex else 0, convex, options.continuous),
        **_island_sizes(n, pairs, options, islands),
    }  # fmt: skip
    floats, ints = at.new_arena(shapes_of(FLOATS, sizes), shapes_of(INTS, sizes))
    _write_bodies(floats, ints, bodies)
    at.float_table(floats, ints, at.REST)[:] = np.inf
    at.float_table(floats, ints, at.POSE)[:, 3:12:4] = 1.0
    for s, (i, solid) in enumerate(shapes):
        if solid.kind == at.PLANE and bodies[i].motion == "dynamic":
            raise ValueError(f"body '{bodies[i].name}': a plane is endless, so its body must be static or kinematic")
        row = at.float_table(floats, ints, at.SHAPE)[s]
        row[at.OFFSET : at.OFFSET + 3] = solid.offset
        row[at.TURN : at.TURN + 4] = solid.turn
        row[at.SIZE : at.SIZE + 3] = solid.size
        row[at.BALL_RADIUS] = solid.radius
        body = at.float_table(floats, ints, at.BODY)[i]
        body[at.EXTENT] = max(body[at.EXTENT], min(float(norm(solid.offset)) + solid.radius, ENDLESS))
        at.int_table(ints, at.SHAPE_KIND)[s] = solid.kind, i, materials.index(bodies[i].material), solid.part
        at.int_table(ints, at.ORDER)[s, 0] = s
        at.int_table(ints, at.POLYHEDRON)[s, at.INNER] = solid.inner
    _write_polyhedra(floats, ints, polyhedra)
    at.int_table(ints, at.JOINT_ORDER)[:, 0] = np.arange(nj)
    for j, joint in enumerate(joints):
        _write_joint(floats, ints, j, joint, index, bodies)
    for (one, two), law in surfaces.items():
        for a, b in ((one, two), (two, one)):
            at.float_table(floats, ints, at.SURFACE)[materials.index(a) * len(materials) + materials.index(b), :5] = (
                law.static_friction, law.kinetic_friction, law.restitution, law.rolling_friction, law.torsional_friction,
            )  # fmt: skip
    for one, two in apart:
        for a, b in ((one, two), (two, one)):
            at.float_table(floats, ints, at.SURFACE)[materials.index(a) * len(materials) + materials.index(b), at.APART] = 1.0
    if excluded:
        at.int_table(ints, at.EXCLUDED)[:] = excluded
    setting = at.float_table(floats, ints, at.SETTING)[0]
    setting[at.DT] = setting[at.WHOLE_STEP] = setting[at.LAST_SPAN] = options.dt
    setting[at.GRAVITY : at.GRAVITY + 3] = finite("world", "gravity", gravity, (3,), "m/s2")
    hertz = options.stiffest_hertz if options.contact_hertz is None else options.contact_hertz
    setting[at.HERTZ], setting[at.DAMPING_RATIO] = hertz, options.contact_damping_ratio
    setting[at.MAX_PUSH], setting[at.MARGIN] = options.max_push, options.margin
    setting[at.STEP_TOLERANCE] = options.used_step_tolerance or 0.0
    setting[at.BOUNCE_SPEED] = -1.0 if options.bounce_speed is None else options.bounce_speed
    count = at.int_table(ints, at.COUNT)[0]
    count[at.BODIES], count[at.SHAPES], count[at.JOINTS] = n, ns, nj
    count[at.SUBSTEPS], count[at.ITERATIONS], count[at.RELAXATIONS] = options.substeps, options.iterations, options.relaxations
    count[at.RUNGE_KUTTA] = int(options.integrator == "rk4")
    count[at.GYROSCOPIC], count[at.CONTINUOUS] = int(options.gyroscopic), CONTINUOUS.index(options.continuous)
    at.int_table(ints, at.PROGRESS)[0, at.CANDIDATES] = -1
    count[at.MATERIALS], count[at.EXCLUSIONS] = len(materials), len(excluded)
    at.int_table(ints, at.TALLY)[0, at.THREADS] = options.threads
    if options.sleeping:
        at.float_table(floats, ints, at.SLEEP)[0] = options.sleep_speed, options.sleep_time
    return floats, ints


def moves_meshes(body: Body) -> bool:
    """Whether forces move a body that has triangle meshes."""
    return body.motion == "dynamic" and any(isinstance(placed.shape, TriangleMesh) for placed in body.shapes)


def _check_closed(body: Body) -> None:
    """Raises: NotSupported for a mesh without an inside, of a body that forces move."""
    for placed in body.shapes:
        if isinstance(placed.shape, TriangleMesh):
            try:
                closed_volume(np.asarray(placed.shape.vertices, float), np.asarray(placed.shape.faces))
            except ValueError as error:
                raise NotSupported(f"triangle mesh of body '{body.name}', which forces move", str(error)) from error


def _check_pairs(surfaces: Mapping[tuple[str, str], Surface], apart: Sequence[tuple[str, str]]) -> None:
    """Raises: ValueError for what is no pair of materials, and for a pair with one law in each order."""
    for field, pairs in (("surfaces", surfaces), ("apart", apart)):
        for pair in pairs:
            if not isinstance(pair, tuple | list) or len(pair) != 2 or not all(isinstance(one, str) for one in pair):
                raise ValueError(f"world: {field} names {pair!r}, expected a pair of materials")
    for (one, two), law in surfaces.items():
        if surfaces.get((two, one), law) != law:
            raise ValueError(f"world: surfaces give {(one, two)} and {(two, one)} different laws, expected one")


def _convex_sizes(polyhedra: Sequence[Polyhedron], pairs: int, convex: bool, continuous: str) -> dict[Per, int]:
    """How many rows the tables of the convex narrow phase have, none where a world needs none.

    Swept collision measures all shapes by GJK and EPA.
    """
    widest = max((len(loop) for one in polyhedra for loop in one.loops), default=0)
    return {
        Per.VERTEX: sum(len(one.vertices) for one in polyhedra),
        Per.FACE: sum(len(one.loops) for one in polyhedra),
        Per.FACE_CORNER: sum(len(loop) for one in polyhedra for loop in one.loops),
        Per.CONVEX_PAIR: pairs,
        Per.CONVEX_POINT: 4 * pairs,
        Per.SIMPLEX_CORNER: 560 if convex or continuous == "swept" else 0,
        Per.POLYGON_CORNER: 3 * (2 * max(widest, 16) + 2) if convex else 0,
    }


def _sweep_sizes(bodies: int, pairs: int, options: Options, spheres: bool) -> dict[Per, int]:
    """How many rows the tables of colours, and of answers at once, have, none where a world needs none."""
    coloured = options.sweeps == COLOURED
    return {
        Per.COLOURED: pairs if coloured else 0,
        Per.BAND: at.COLOURS * at.MOST_BANDS + 1 if coloured else 0,
        Per.BANDED_WORLD: int(coloured),
        Per.COLOURED_MOVER: bodies + 1 if coloured and spheres else 0,
        Per.ANSWERING_PAIR: pairs if options.sweeps == JACOBI else 0,
    }


def _island_sizes(bodies: int, pairs: int, options: Options, wanted: bool) -> dict[Per, int]:
    """How many rows the tables of islands and of sleep have, none where a world needs none."""
    rests = pairs if options.sleeping else 0
    return {
        Per.MEMBER: bodies + 1 if wanted else 0,
        Per.SPAN: bodies + 3 if wanted else 0,
        Per.SLEEPER: bodies + 1 if options.sleeping else 0,
        Per.RESTING_PAIR: rests,
        Per.RESTING_POINT: 4 * rests,
    }


def _write_polyhedra(floats: Floats, ints: Ints, polyhedra: Sequence[tuple[int, Polyhedron]]) -> None:
    """Fill the tables of corners and faces; the number in front of each polyhedron is its shape."""
    vertex, face = at.float_table(floats, ints, at.VERTEX), at.float_table(floats, ints, at.FACE)
    table, span, loop = at.int_table(ints, at.POLYHEDRON), at.int_table(ints, at.SPAN), at.int_table(ints, at.LOOP)
    v, f, c = 0, 0, 0
    for s, one in polyhedra:
        table[s, : at.INNER] = v, len(one.vertices), f, len(one.loops)
        vertex[v : v + len(one.vertices)], face[f : f + len(one.loops)] = one.vertices, one.normals
        for corners in one.loops:
            span[f] = c, len(corners)
            loop[c : c + len(corners), 0] = np.array(corners) + v
            f, c = f + 1, c + len(corners)
        v += len(one.vertices)


def _write_bodies(floats: Floats, ints: Ints, bodies: Sequence[Body]) -> None:
    """Fill the tables of states, masses and kinds."""
    state, table = at.float_table(floats, ints, at.STATE), at.float_table(floats, ints, at.BODY)
    turned, kind = at.float_table(floats, ints, at.TURNED), at.int_table(ints, at.BODY_KIND)
    principal = at.float_table(floats, ints, at.PRINCIPAL)
    state[:, at.Q] = 1.0
    for i, body in enumerate(bodies):
        label = f"body '{body.name}'"
        q = unit_quaternion(label, "q_WB", body.q_WB)
        state[i, at.P : at.P + 3], state[i, at.Q : at.Q + 4] = body.p_WB, q
        state[i, at.V : at.V + 3], state[i, at.W : at.W + 3] = body.v_WB, body.w_WB
        kind[i, at.MOTION] = MOTIONS[body.motion]
        if body.motion != "dynamic" or body.massless:
            continue
        inertia = spd_inertia(label, body.inertia)
        mobility = inverse(inertia)
        table[i, at.INV_MASS], table[i, at.MASS] = 1 / body.mass, body.mass
        table[i, at.INERTIA : at.INERTIA + 6], table[i, at.INV_INERTIA : at.INV_INERTIA + 6] = six(inertia), six(mobility)
        table[i, at.LINEAR_DAMPING], table[i, at.ANGULAR_DAMPING] = body.linear_damping, body.angular_damping
        table[i, at.ROUND] = float(np.array_equal(inertia, inertia[0, 0] * np.eye(3)))
        if len(principal) > 0:
            principal[i, at.MOMENTS : at.MOMENTS + 3], principal[i, at.AXES : at.AXES + 4] = principal_frame(inertia)
        r = quat_mat(q)
        turned[i] = six(mat_mat(mat_mat(r, mobility), r.T))


def _along(joint: Joint) -> int:
    """How many rows the rotor, the dry friction and the limit of speed of a joint take."""
    if not isinstance(joint, Revolute | Prismatic):
        return 0
    return (joint.armature > 0) + (joint.friction_loss > 0) + 2 * (joint.speed_limit < math.inf)


def _rate(joint: Joint, axis: Floats, state_a: Floats, state_b: Floats, anchor: Floats) -> float:
    """The rate of a joint's coordinate at the start [rad/s or m/s], of bodies in these states (13,), about or along an axis."""
    w_a, w_b = state_a[at.W : at.W + 3], state_b[at.W : at.W + 3]
    if isinstance(joint, Revolute):
        return float(dot(axis, w_b - w_a))
    v_a, v_b = (state[at.V : at.V + 3] + np.cross(state[at.W : at.W + 3], anchor - state[:3]) for state in (state_a, state_b))
    return float(dot(axis, v_b - v_a))


def _write_joint(floats: Floats, ints: Ints, j: int, joint: Joint, index: Mapping[str, int], bodies: Sequence[Body]) -> None:
    """Fill one row of the tables of joints. Raises: ValueError for unknown bodies, or two that cannot move."""
    label = f"joint '{joint.name}'"
    for role in ("parent", "child"):
        if getattr(joint, role) not in index:
            raise ValueError(f"{label}: {role} '{getattr(joint, role)}' is no body, expected one of {', '.join(index)}")
    a, b = index[joint.parent], index[joint.child]
    if a == b:
        raise ValueError(f"{label}: parent and child are both '{joint.parent}'")
    if all(i == len(bodies) or bodies[i].motion != "dynamic" for i in (a, b)):
        raise ValueError(f"{label}: neither '{joint.parent}' nor '{joint.child}' is dynamic")
    state = at.float_table(floats, ints, at.STATE)
    row, kind = at.float_table(floats, ints, at.JOINT)[j], at.int_table(ints, at.JOINT_KIND)[j]
    ra, rb = quat_mat(state[a, at.Q : at.Q + 4]), quat_mat(state[b, at.Q : at.Q + 4])
    kind[at.HAS] = write_laws(row, None, None, None)
    kind[[at.PARENT, at.CHILD]] = a, b
    qa = state[a, at.Q : at.Q + 4] * (1, -1, -1, -1)
    row[at.TURN_AB : at.TURN_AB + 4] = quat_mul(qa, state[b, at.Q : at.Q + 4])
    anchor_a = state[b, :3] if isinstance(joint, Fixed) else np.asarray(joint.anchor_W, float)
    anchor_b = np.asarray(joint.child_anchor_W, float) if isinstance(joint, Distance) else anchor_a
    row[at.ANCHOR_A : at.ANCHOR_A + 3] = mat_vec(ra.T, anchor_a - state[a, :3])
    row[at.ANCHOR_B : at.ANCHOR_B + 3] = mat_vec(rb.T, anchor_b - state[b, :3])
    if isinstance(joint, Fixed):
        kind[at.JOINT_TYPE] = at.FIXED
        return
    if isinstance(joint, Ball):
        kind[at.JOINT_TYPE] = at.BALL
        return
    if isinstance(joint, Distance):
        kind[at.JOINT_TYPE] = at.DISTANCE
        row[at.LENGTH] = float(norm(anchor_b - anchor_a))
    else:
        kind[at.JOINT_TYPE] = at.REVOLUTE if isinstance(joint, Revolute) else at.PRISMATIC
        axis = unit(np.asarray(joint.axis_W, float))
        row[at.AXIS_A : at.AXIS_A + 3], row[at.AXIS_B : at.AXIS_B + 3] = mat_vec(ra.T, axis), mat_vec(rb.T, axis)
        row[at.POSITION] = row[at.COORDINATE] = joint.position
        if joint.armature > 0:
            kind[at.HAS] |= at.HAS_ARMATURE
            row[at.ARMATURE], row[at.ROTOR_RATE] = joint.armature, _rate(joint, axis, state[a], state[b], anchor_a)
        if joint.friction_loss > 0:
            kind[at.HAS] |= at.HAS_FRICTION
            row[at.FRICTION_LOSS] = joint.friction_loss
        if joint.speed_limit < math.inf:
            kind[at.HAS] |= at.HAS_SPEED_LIMIT
            row[at.SPEED_LIMIT] = joint.speed_limit
    kind[at.HAS] |= write_laws(row, joint.limits, joint.spring, None if isinstance(joint, Distance) else joint.drive)


def write_laws(row: Floats, limits: Limits | None, spring: Spring | None, drive: Drive | None) -> int:
    """Fill what acts along a coordinate in the row of a joint. Returns: the bits of HAS."""
    has = 0
    row[at.LOWER], row[at.UPPER], row[at.DRIVE + 4] = -math.inf, math.inf, math.inf
    if limits is not None:
        has |= at.HAS_LIMITS
        row[at.LOWER], row[at.UPPER] = limits.lower, limits.upper
    if spring is not None:
        has |= at.HAS_SPRING
        row[at.SPRING : at.SPRING + 3] = spring.stiffness, spring.damping, spring.rest
    if drive is not None:
        has |= at.HAS_DRIVE
        row[at.DRIVE : at.DRIVE + 5] = drive.stiffness, drive.damping, drive.target, drive.target_velocity, drive.limit
    return has


def grow(floats: Floats, ints: Ints) -> tuple[Floats, Ints]:
    """The same world in an arena with room for twice as many pairs, or so often twice that those found find it."""
    old_floats = [at.float_table(floats, ints, k) for k in range(at.FLOAT_TABLES)]
    old_ints = [at.int_table(ints, k) for k in range(at.INT_TABLES)]
    times, room, found = 2, len(old_ints[at.PAIR]), old_ints[at.COUNT][0, at.PAIRS]
    while 0 < times * room < found:
        times *= 2
    more = [[times if table.rows.grows else 1 for table in tables] for tables in (FLOATS, INTS)]
    new_floats, new_ints = at.new_arena(
        [(grown * old.shape[0], old.shape[1]) for grown, old in zip(more[0], old_floats, strict=True)],
        [(grown * old.shape[0], old.shape[1]) for grown, old in zip(more[1], old_ints, strict=True)],
    )
    for k, table in enumerate(old_floats):
        at.float_table(new_floats, new_ints, k)[: table.shape[0]] = table
    for k, whole in enumerate(old_ints):
        at.int_table(new_ints, k)[: whole.shape[0]] = whole
    return new_floats, new_ints
