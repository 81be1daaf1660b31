"""Write bodies, shapes, joints and surfaces into a new arena."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from plumbline.engine.build.initial_rates import coordinate_rate
from plumbline.engine.build.joint_order import ROWS, mechanisms, neighbours
from plumbline.engine.build.polyhedra import Polyhedron, check_closed
from plumbline.engine.build.solids import Solid, body_solids, principal_frame, quat_mat, quat_mul
from plumbline.engine.describe.bodies import Body, Surface
from plumbline.engine.describe.check import finite, spd_inertia, unit_quaternion
from plumbline.engine.describe.joints import WORLD, Ball, Distance, Drive, Fixed, Joint, Limits, Prismatic, Revolute, Spring
from plumbline.engine.describe.shapes import Box, Plane, Sphere, TriangleMesh
from plumbline.engine.maths.arrays import inverse, mat_mat, mat_vec, norm, unit
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.layout import FLOATS, INTS, Per, shapes_of
from plumbline.engine.options import COLOURED, CONTINUOUS, FREE_INTEGRATORS, GAUSS_SEIDEL, JACOBI, Options

MOTIONS = {"static": at.STATIC, "kinematic": at.KINEMATIC, "dynamic": at.DYNAMIC}
TYPES = {Fixed: at.FIXED, Ball: at.BALL, Revolute: at.REVOLUTE, Prismatic: at.PRISMATIC, Distance: at.DISTANCE}
ENDLESS = 1e9
"""The extent [m] of a plane: where it turns at all, it does not count as still."""

Tables = tuple[list[Floats], list[Ints]]
"""Those of an arena, as `arena.tables` returns them."""
Pairs = Sequence[tuple[str, str]]
"""Of materials."""


def six(m: Floats) -> list[float]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric matrix."""
    return [m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2]]


def spheres_only(
    bodies: Sequence[Body], joints: Sequence[Joint], surfaces: Mapping[tuple[str, str], Surface], options: Options
) -> bool:
    """Whether the world is one that `engine.steps.spheres` serves."""
    if not (options.contacts and islands_know(options)) or options.sleeping or options.sweeps == JACOBI or joints:
        return False
    if any(law.rolling_friction > 0 or law.torsional_friction > 0 for law in surfaces.values()):
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
    if not islands_know(options) or options.sweeps != GAUSS_SEIDEL:
        return False
    return options.threads > 1 or options.sleeping or len(mechanisms(neighbours(bodies, joints))) > 1


def assemble_world(
    bodies: Sequence[Body], joints: Sequence[Joint], surfaces: Mapping[tuple[str, str], Surface], gravity: Sequence[float],
    options: Options, apart: Pairs = (), islands: bool = False,
) -> tuple[Floats, Ints]:  # fmt: skip
    """The arena of a world at its start, with room for islands where it has any. Raises: ValueError, NotSupported."""
    _check_pairs(surfaces, apart)
    _check_names("joint", [joint.name for joint in joints])
    _check_names("body", [WORLD, *(body.name for body in bodies)])
    index = {name: i for i, name in enumerate((*(body.name for body in bodies), WORLD))}
    for body in bodies:
        for placed in body.shapes if body.motion == "dynamic" else ():
            if isinstance(placed.shape, TriangleMesh):
                check_closed(placed.shape, f"triangle mesh of body '{body.name}', which forces move")
    solids = [(i, solid) for i, body in enumerate(bodies) for solid in body_solids(body)]
    materials = sorted({body.material for body in bodies} | {one for pair in (*surfaces, *apart) for one in pair})
    ends = [(index.get(joint.parent), index.get(joint.child)) for joint in joints if not joint.collide]
    excluded = [pair for pair in ends if None not in pair]
    spheres = spheres_only(bodies, joints, surfaces, options)
    sizes = _sizes(bodies, joints, solids, options, spheres, islands)
    sizes |= {Per.EXCLUDED: len(excluded), Per.LAW: len(materials) * len(materials)}
    floats, ints = at.new_arena(shapes_of(sizes))
    tables = floats_of, ints_of = at.tables(floats, ints)
    _write_bodies(tables, bodies)
    _write_shapes(tables, bodies, solids, materials)
    if sizes[Per.VERTEX]:
        _write_polyhedra(tables, [solid.polyhedron for _, solid in solids])
    ints_of[at.JOINT_ORDER][:, 0] = np.arange(len(joints))
    named = {body.name: body for body in bodies}
    for j, joint in enumerate(joints):
        _write_joint(tables, j, joint, index, named)
    ints_of[at.EXCLUDED][:] = np.array(excluded, np.int64).reshape(-1, 2)
    law = floats_of[at.SURFACE].reshape(len(materials), len(materials), -1)
    for pair, surface in surfaces.items():
        a, b = map(materials.index, pair)
        law[[a, b], [b, a], : at.APART] = (
            surface.static_friction, surface.kinetic_friction, surface.restitution, surface.rolling_friction,
            surface.torsional_friction,
        )  # fmt: skip
    for pair in apart:
        a, b = map(materials.index, pair)
        law[[a, b], [b, a], at.APART] = 1.0
    setting, count = floats_of[at.SETTING][0], ints_of[at.COUNT][0]
    setting[at.DT] = setting[at.WHOLE_STEP] = setting[at.LAST_SPAN] = options.dt
    setting[at.GRAVITY : at.GRAVITY + 3] = finite("world", "gravity", gravity, (3,), "m/s2")
    setting[at.HERTZ] = options.stiffest_hertz if options.contact_hertz is None else options.contact_hertz
    setting[at.DAMPING_RATIO] = options.contact_damping_ratio
    setting[at.MAX_PUSH], setting[at.MARGIN] = options.max_push, options.margin
    setting[at.STEP_TOLERANCE] = options.used_step_tolerance or 0.0
    setting[at.BOUNCE_SPEED] = -1.0 if options.bounce_speed is None else options.bounce_speed
    count[at.BODIES], count[at.SHAPES], count[at.JOINTS] = len(bodies), len(solids), len(joints)
    count[at.SUBSTEPS], count[at.ITERATIONS], count[at.RELAXATIONS] = options.substeps, options.iterations, options.relaxations
    count[at.RUNGE_KUTTA] = int(options.integrator == "rk4")
    count[at.GYROSCOPIC], count[at.CONTINUOUS] = int(options.gyroscopic), CONTINUOUS.index(options.continuous)
    count[at.MATERIALS], count[at.EXCLUSIONS] = len(materials), len(excluded)
    ints_of[at.PROGRESS][0, at.CANDIDATES] = -1
    ints_of[at.TALLY][0, at.THREADS] = options.threads
    if options.sleeping:
        floats_of[at.SLEEP][0] = options.sleep_speed, options.sleep_time
    return floats, ints


def may_touch(bodies: Sequence[Body]) -> bool:
    """Whether two bodies have shapes and one of them is dynamic."""
    solid = [body for body in bodies if body.shapes]
    return len(solid) > 1 and any(body.motion == "dynamic" for body in solid)


def moves_meshes(body: Body) -> bool:
    """Whether forces move a body that has triangle meshes."""
    return body.motion == "dynamic" and any(isinstance(placed.shape, TriangleMesh) for placed in body.shapes)


def _check_names(what: str, names: Sequence[str]) -> None:
    """Raises: ValueError naming the first that was there before."""
    known: set[str] = set()
    for name in names:
        if name in known:
            raise ValueError(f"{what} '{name}': the name is taken")
        known.add(name)


def _check_pairs(surfaces: Mapping[tuple[str, str], Surface], apart: Pairs) -> None:
    """Raises: ValueError for what is no pair of materials, and for a pair with one law in each order."""
    for field, pairs in (("surfaces", surfaces), ("apart", apart)):
        for pair in pairs:
            if not isinstance(pair, tuple | list) or len(pair) != 2 or not all(isinstance(one, str) for one in pair):
                raise ValueError(f"world: {field} names {pair!r}, expected a pair of materials")
    for (one, two), law in surfaces.items():
        if surfaces.get((two, one), law) != law:
            raise ValueError(f"world: surfaces give {(one, two)} and {(two, one)} different laws, expected one")


def _sizes(
    bodies: Sequence[Body], joints: Sequence[Joint], solids: Sequence[tuple[int, Solid]], options: Options, spheres: bool,
    islands: bool,
) -> dict[Per, int]:  # fmt: skip
    """How many rows tables have: none of what a world has no use for. Swept collision measures all shapes by GJK and EPA."""
    n, shapes, rows = len(bodies) + 1, len(solids), 1 + sum(ROWS[type(joint)] + 3 for joint in joints)
    rows += sum(count for joint in joints for *_, count in _beside_laws(joint))
    movable = sum(bodies[i].motion == "dynamic" for i, _ in solids)
    near = min(shapes * (shapes - 1) // 2, 8 * movable + 16) if options.contacts else 0
    pairs = 0 if spheres else near
    convex = any(solid.kind in (at.CYLINDER, at.ELLIPSOID, at.HULL, at.TRIANGLE) for _, solid in solids)
    polyhedra = [solid.polyhedron for _, solid in solids if convex and solid.polyhedron is not None]
    faces = [len(loop) for one in polyhedra for loop in one.loops]
    coloured, resting = options.sweeps == COLOURED, options.sleeping * pairs
    return {
        Per.WORLD: 1, Per.BODY: n, Per.SHAPE: shapes, Per.JOINT: len(joints), Per.ROW: rows, Per.ROW_OR_TRIAL: 2 * rows + 2,
        Per.VECTOR: at.CAREFUL + 1, Per.CLIP_POINT: 32, Per.VERTEX: sum(len(one.vertices) for one in polyhedra),
        Per.FACE: len(faces), Per.FACE_CORNER: sum(faces),
        Per.SIMPLEX_CORNER: 560 if convex or options.continuous == "swept" else 0,
        Per.POLYGON_CORNER: 3 * (2 * max([16, *faces]) + 2) if convex else 0,
        Per.PRINCIPAL_BODY: n if options.integrator in FREE_INTEGRATORS else 0, Per.MOVER: n if spheres else 0,
        Per.MEMBER: n if islands else 0, Per.SPAN: n + 2 if islands else 0, Per.SLEEPER: n if options.sleeping else 0,
        Per.NEAR: near, Per.PAIR: pairs, Per.POINT: 4 * pairs + 1, Per.OLD_POINT: 4 * pairs, Per.TOUCH: near - pairs,
        Per.CONVEX_PAIR: convex * pairs, Per.CONVEX_POINT: 4 * convex * pairs,
        Per.COLOURED: coloured * near, Per.BAND: coloured * (at.COLOURS * at.MOST_BANDS + 1), Per.BANDED_WORLD: int(coloured),
        Per.COLOURED_MOVER: n if coloured and spheres else 0, Per.ANSWERING_PAIR: near if options.sweeps == JACOBI else 0,
        Per.RESTING_PAIR: resting, Per.RESTING_POINT: 4 * resting,
    }  # fmt: skip


def _write_shapes(
    tables: Tables, bodies: Sequence[Body], solids: Sequence[tuple[int, Solid]], materials: Sequence[str]
) -> None:
    """Fill the tables of shapes. Raises: ValueError for a plane that forces move."""
    floats, ints = tables
    floats[at.REST][:] = np.inf
    floats[at.POSE][:, 3:12:4] = 1.0
    ints[at.ORDER][:, 0] = np.arange(len(solids))
    for s, (i, solid) in enumerate(solids):
        if solid.kind == at.PLANE and bodies[i].motion == "dynamic":
            raise ValueError(f"body '{bodies[i].name}': a plane is endless, so its body must be static or kinematic")
        row, body = floats[at.SHAPE][s], floats[at.BODY][i]
        row[at.OFFSET : at.OFFSET + 3], row[at.TURN : at.TURN + 4] = solid.offset, solid.turn
        row[at.SIZE : at.SIZE + 3], row[at.BALL_RADIUS] = solid.size, solid.radius
        body[at.EXTENT] = max(body[at.EXTENT], min(float(norm(solid.offset)) + solid.radius, ENDLESS))
        ints[at.SHAPE_KIND][s] = solid.kind, i, materials.index(bodies[i].material), solid.part
        ints[at.POLYHEDRON][s, at.INNER] = solid.inner


def _write_polyhedra(tables: Tables, polyhedra: Sequence[Polyhedron | None]) -> None:
    """Fill the tables of corners and faces, of the shapes in turn."""
    floats, ints = tables
    span, loop = ints[at.SPAN], ints[at.LOOP]
    v, f, c = 0, 0, 0
    for s, one in enumerate(polyhedra):
        if one is None:
            continue
        ints[at.POLYHEDRON][s, : at.INNER] = v, len(one.vertices), f, len(one.loops)
        floats[at.VERTEX][v : v + len(one.vertices)], floats[at.FACE][f : f + len(one.loops)] = one.vertices, one.normals
        for corners in one.loops:
            span[f] = c, len(corners)
            loop[c : c + len(corners), 0] = np.array(corners) + v
            f, c = f + 1, c + len(corners)
        v += len(one.vertices)


def _write_bodies(tables: Tables, bodies: Sequence[Body]) -> None:
    """Fill the tables of states, masses and kinds."""
    floats, ints = tables
    state, table, turned, principal = (floats[k] for k in (at.STATE, at.BODY, at.TURNED, at.PRINCIPAL))
    state[:, at.Q] = 1.0
    for i, body in enumerate(bodies):
        label = f"body '{body.name}'"
        q = unit_quaternion(label, "q_WB", body.q_WB)
        state[i] = *body.p_WB, *q, *body.v_WB, *body.w_WB
        ints[at.BODY_KIND][i, at.MOTION] = MOTIONS[body.motion]
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


def _write_joint(tables: Tables, j: int, joint: Joint, index: Mapping[str, int], bodies: Mapping[str, Body]) -> None:
    """Fill one row of the tables of joints. Raises: ValueError for unknown bodies, or two that cannot move."""
    label = f"joint '{joint.name}'"
    for role in ("parent", "child"):
        if getattr(joint, role) not in index:
            raise ValueError(f"{label}: {role} '{getattr(joint, role)}' is no body, expected one of {', '.join(index)}")
    a, b = index[joint.parent], index[joint.child]
    if a == b:
        raise ValueError(f"{label}: parent and child are both '{joint.parent}'")
    if not any(name in bodies and bodies[name].motion == "dynamic" for name in (joint.parent, joint.child)):
        raise ValueError(f"{label}: neither '{joint.parent}' nor '{joint.child}' is dynamic")
    floats, ints = tables
    state, row, kind = floats[at.STATE], floats[at.JOINT][j], ints[at.JOINT_KIND][j]
    ra, rb = quat_mat(state[a, at.Q : at.Q + 4]), quat_mat(state[b, at.Q : at.Q + 4])
    qa = state[a, at.Q : at.Q + 4] * (1, -1, -1, -1)
    row[at.TURN_AB : at.TURN_AB + 4] = quat_mul(qa, state[b, at.Q : at.Q + 4])
    anchor_a = state[b, :3] if isinstance(joint, Fixed) else np.asarray(joint.anchor_W, float)
    anchor_b = np.asarray(joint.child_anchor_W, float) if isinstance(joint, Distance) else anchor_a
    row[at.ANCHOR_A : at.ANCHOR_A + 3] = mat_vec(ra.T, anchor_a - state[a, :3])
    row[at.ANCHOR_B : at.ANCHOR_B + 3] = mat_vec(rb.T, anchor_b - state[b, :3])
    laws = (
        (None, None, None) if isinstance(joint, Fixed | Ball) else (joint.limits, joint.spring, getattr(joint, "drive", None))
    )
    kind[[at.JOINT_TYPE, at.PARENT, at.CHILD, at.HAS]] = TYPES[type(joint)], a, b, write_laws(row, *laws)
    if isinstance(joint, Distance):
        row[at.LENGTH] = float(norm(anchor_b - anchor_a))
    elif isinstance(joint, Revolute | Prismatic):
        axis = unit(np.asarray(joint.axis_W, float))
        row[at.AXIS_A : at.AXIS_A + 3], row[at.AXIS_B : at.AXIS_B + 3] = mat_vec(ra.T, axis), mat_vec(rb.T, axis)
        row[at.POSITION] = row[at.COORDINATE] = joint.position
        for bit, column, value, _ in _beside_laws(joint):
            kind[at.HAS] |= bit
            row[column] = value
        if joint.armature > 0:
            row[at.ROTOR_RATE], _ = coordinate_rate(bodies, joint)


def _beside_laws(joint: Joint) -> Iterator[tuple[int, int, float, int]]:
    """Of the rotor, the dry friction and the limit of speed of a joint that it has: bit of HAS, column, value, and rows."""
    if not isinstance(joint, Revolute | Prismatic):
        return
    if joint.armature > 0:
        yield at.HAS_ARMATURE, at.ARMATURE, joint.armature, 1
    if joint.friction_loss > 0:
        yield at.HAS_FRICTION, at.FRICTION_LOSS, joint.friction_loss, 1
    if joint.speed_limit < math.inf:
        yield at.HAS_SPEED_LIMIT, at.SPEED_LIMIT, joint.speed_limit, 2


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
    old_floats, old_ints = at.tables(floats, ints)
    times, room, found = 2, len(old_ints[at.PAIR]), old_ints[at.COUNT][0, at.PAIRS]
    while 0 < times * room < found:
        times *= 2
    old: list[Floats | Ints] = [*old_floats, *old_ints]
    more = [times if table.rows.grows else 1 for table in FLOATS + INTS]
    new_floats, new_ints = at.new_arena(np.array([(k * len(one), one.shape[1]) for k, one in zip(more, old, strict=True)]))
    for new, one in zip((k for of in at.tables(new_floats, new_ints) for k in of), old, strict=True):
        new[: len(one)] = one
    return new_floats, new_ints
