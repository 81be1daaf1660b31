"""Why Rapier is best or worst of some cases as it comes, in rapier3d's own words."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from tests.vendor.rapier_world import STILL, G, rapier, solid, world
from tests.vendor.spinning import STEM, TILT, TOP, centre, top_rate

pytestmark = pytest.mark.rapier
ACROSS = rapier.Rotation3(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Turns x to y."""
Point = tuple[float, float, float]


def floor(here: rapier.PhysicsWorld, friction: float = 0.0, restitution: float = 0.0) -> None:
    plane = rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(friction).restitution(restitution)
    here.add_body(rapier.RigidBody.fixed(), [plane])


def ball(radius: float, friction: float = 0.0, restitution: float = 0.0) -> rapier.ColliderBuilder:
    return rapier.Collider.ball(radius).density(0.0).friction(friction).restitution(restitution)


def at(p: Sequence[float], q: rapier.Rotation3 = STILL) -> rapier.Isometry3:
    return rapier.Isometry3(tuple(p), q)


def runge_kutta(rate: Callable[[np.ndarray], np.ndarray], start: Sequence[float], seconds: float, steps: int) -> np.ndarray:
    """States (steps + 1, n) of y' = rate(y)."""
    h, states = seconds / steps, [np.array(start, dtype=np.float64)]
    for _ in range(steps):
        y = states[-1]
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        states.append(y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c)))
    return np.array(states)


# Bodies that are led


def strayed(told: bool, shape: rapier.ColliderBuilder) -> float:
    """How far [m] a body whose shape is 30 mm off it goes from its place in half a turn. Args: told: its mass and centre."""
    here = world(0.0)
    build = rapier.RigidBody.kinematic_velocity_based().angvel((0.0, math.pi, 0.0))
    if told:
        build = build.additional_mass_properties(rapier.MassProperties((0.0, 0.0, 0.0), 1.0, (0.1,) * 3, STILL))
    body = here.add_body(build, [shape.density(0.0).position(at((0.03, 0.0, 0.0)))])
    for _ in range(240):
        here.step()
    return math.dist(here.rigid_bodies[body].translation.to_tuple(), (0.0, 0.0, 0.0))


def test_a_body_that_is_led_turns_about_the_middle_of_its_shapes_unless_it_is_told_another_centre() -> None:
    for shape in (rapier.Collider.ball, lambda r: rapier.Collider.cuboid(r, r, r)):
        assert strayed(False, shape(0.1)) == pytest.approx(0.06, rel=1e-4)
        assert strayed(True, shape(0.1)) < 1e-6


# Sleep


def crept(sleeps: bool, substeps: int = 4) -> float:
    """Where [m] a mass on a rail is after 5 s whose spring and damper, twice the critical one, pull it back from .3 m."""
    here, rate, ratio = world(0.0, substeps=substeps), 6.0, 2.0
    anchor = here.add_body(rapier.RigidBody.fixed(), [])
    mass = here.add_body(solid(1.0, (1 / 150,) * 3, (0.3, 0.0, 0.0)).can_sleep(sleeps), [])
    rail = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_PRISMATIC_AXES)
    rail = rail.motor_model(rapier.JointAxis.LIN_X, rapier.MotorModel.FORCE_BASED)
    rail = rail.motor(rapier.JointAxis.LIN_X, 0.0, 0.0, rate**2, 2 * rate * ratio)
    here.impulse_joints.insert(anchor, mass, rail.build())
    for _ in range(1200):
        here.step()
    return here.rigid_bodies[mass].translation.x


def test_a_mass_that_creeps_back_is_put_to_sleep_on_its_way() -> None:
    """Awake it comes within roundings of its spring's rest; asleep it stays, whatever the sub-steps."""
    for substeps in (1, 4, 16):
        assert 0.02 < crept(True, substeps) < 0.035
    assert abs(crept(False)) < 1e-3


def slid(sleeps: bool, over: float = 1.01) -> float:
    """By what share of g the mean acceleration in a second is off, of a box on an incline `over` its friction of .5."""
    lean = math.atan(0.5 * over)
    here = world()
    here.gravity = (G * math.sin(lean), 0.0, -G * math.cos(lean))
    floor(here, 0.5)
    shape = rapier.Collider.cuboid(0.1, 0.1, 0.025).density(0.0).friction(0.5)
    box = here.add_body(solid(1.0, (0.005,) * 3, (0.0, 0.0, 0.025)).can_sleep(sleeps), [shape])
    for _ in range(240):
        here.step()
    due = math.sin(lean) - 0.5 * math.cos(lean)
    return abs(2 * here.rigid_bodies[box].translation.x / G - due)


def test_a_box_that_begins_to_slide_is_put_to_sleep_on_its_way() -> None:
    """One to three per cent over its friction it is asleep within the second; ten per cent over it is too fast for that."""
    for over in (1.01, 1.02, 1.03):
        assert slid(True, over) > 0.7 * 0.5 * (over - 1) * math.cos(math.atan(0.5))
        assert slid(False, over) < 1e-3
    assert slid(True, 1.1) < 1e-3


# Four steps of a quarter


def stopped(substeps: int) -> float:
    """How far off v^2/(2 mu g) [m] a box stops that slid off at 2 m/s, of a friction of .2."""
    here = world(substeps=substeps)
    floor(here, 0.2)
    shape = rapier.Collider.cuboid(0.2, 0.2, 0.05).density(0.0).friction(0.2)
    box = here.add_body(solid(1.0, (0.02,) * 3, (0.0, 0.0, 0.05)).linvel((2.0, 0.0, 0.0)), [shape])
    for _ in range(480):
        here.step()
    return abs(float(here.rigid_bodies[box].translation.x) - 4.0 / (0.4 * G))


def pinched(substeps: int) -> float:
    """How far off g (1 - 2 mu) t^2/2 [m] a box has slid down in a second that its double weight presses at a wall, mu = .3."""
    here = world(substeps=substeps)
    here.gravity = (0.0, G, -2 * G)
    floor(here, 0.3)
    shape = rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0).friction(0.3)
    box = here.add_body(solid(1.0, (1 / 150,) * 3, (0.0, 0.0, 0.1)), [shape])
    for _ in range(240):
        here.step()
    return abs(here.rigid_bodies[box].translation.y - 0.2 * G)


def swung(substeps: int) -> float:
    """How far [m] the lower of two rods of a metre at 90 and 0 degrees goes astray in a second on two hinges."""

    def rate(y: np.ndarray) -> np.ndarray:
        a, b, u, w = y
        c, s = math.cos(a - b) / 2, math.sin(a - b) / 2
        force = [-s * w * w - 1.5 * G * math.sin(a), s * u * u - 0.5 * G * math.sin(b)]
        return np.concatenate(([u, w], np.linalg.solve([[4 / 3, c], [c, 1 / 3]], force)))

    truth = runge_kutta(rate, (math.pi / 2, 0.0, 0.0, 0.0), 1.0, 960)[::4]
    here, hinge = world(substeps=substeps), rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    anchor = here.add_body(rapier.RigidBody.fixed(), [])
    upper = here.add_body(solid(1.0, (1 / 12, 1 / 12, 1e-3), (0.5, 0.0, 0.0)), [])
    lower = here.add_body(solid(1.0, (1 / 12, 1 / 12, 1e-3), (1.0, 0.0, -0.5)), [])
    # The upper rod lies level at the start: its moments are told about axes that are turned with it.
    turned = rapier.MassProperties((0.0, 0.0, 0.0), 1.0, (1e-3, 1 / 12, 1 / 12), STILL)
    here.rigid_bodies[upper].set_additional_mass_properties(turned, True)
    for first, second, on_first, on_second in (
        (anchor, upper, (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0)),
        (upper, lower, (0.5, 0.0, 0.0), (0.0, 0.0, 0.5)),
    ):
        here.impulse_joints.insert(
            first, second, hinge.local_frame1(at(on_first, ACROSS)).local_frame2(at(on_second, ACROSS)).build()
        )
    off = 0.0
    for a, b, *_ in truth[1:]:
        here.step()
        p = here.rigid_bodies[lower].translation
        off = max(off, math.hypot(p.x - math.sin(a) - math.sin(b) / 2, p.z + math.cos(a) + math.cos(b) / 2))
    return off


def spun(substeps: int) -> float:
    """By what share of it the angular momentum of a small plate goes astray in 2 s at 100 rad/s about no principal axis."""
    here, moments = world(0.0, substeps=substeps), np.array([4.25e-6, 9.25e-6, 1.3e-5])
    start = np.array([80.2, 10.0, 58.9])
    plate = here.add_body(solid(0.03, tuple(moments.tolist()), (0.0, 0.0, 0.0)).angvel(tuple(start.tolist())), [])
    off = 0.0
    for _ in range(480):
        here.step()
        body = here.rigid_bodies[plate]
        there = np.array(body.rotation.to_matrix()).reshape(3, 3)
        w = np.array(body.angvel.to_tuple())
        momentum = there @ (moments * (there.T @ w))
        off = max(off, float(np.linalg.norm(momentum - moments * start) / np.linalg.norm(moments * start)))
    return off


def shaken(substeps: int) -> float:
    """How late [s] a body is in its way that is given a steady push: half a sub-step."""
    here = world(3.0, substeps=substeps)
    body = here.rigid_bodies[here.add_body(solid(2.0, (0.2,) * 3, (0.0, 0.0, 0.0)), [])]
    for _ in range(240):
        here.step()
    return abs(body.translation.z + 1.5) / abs(body.linvel.z)


def fell_over(substeps: int, contact_rate: float | None = None) -> float:
    """How far [m] a rod strays in an eighth of a second that is pushed foot first at 8 m/s over ground of a friction of 1.

    Args: contact_rate: of contacts [Hz], None as they come.
    """
    radius, lean, speed = 0.01, math.atan(2.0), 8.0

    def rate(y: np.ndarray) -> np.ndarray:
        _, a, u, w = y
        turning = math.sin(a) + radius - math.cos(a)
        load = (G - w * w * math.sin(a)) / (1.0 - 3.0 * math.cos(a) * turning)
        return np.array([u, w, load, 3.0 * load * turning])

    truth = runge_kutta(rate, (0.0, lean, -speed, 0.0), 0.125, 480)[::4]
    here = world(dt=1 / 960, substeps=substeps)
    if contact_rate is not None:
        here.integration_parameters.static_contact_softness = rapier.SpringCoefficients(contact_rate, 10.0)
    floor(here, 1.0)
    half = (math.pi / 2 - lean) / 2
    turn = rapier.Rotation3(math.cos(half), 0.0, math.sin(half), 0.0)
    build = solid(1.0, (1 / 3, 1 / 3, 5e-5), (0.0, 0.0, 0.0)).position(at((0.0, 0.0, radius + math.sin(lean)), turn))
    feet = [ball(radius, 1.0).position(at((0.0, 0.0, end))) for end in (-1.0, 1.0)]
    rod = here.add_body(build.linvel((-speed, 0.0, 0.0)).gyroscopic_forces(False), feet)
    off = 0.0
    for x, a, *_ in truth[1:]:
        here.step()
        p = here.rigid_bodies[rod].translation
        off = max(off, math.hypot(p.x - x, p.z - radius - math.sin(a)))
    return off


def toppled(substeps: int) -> float:
    """How far [m] a disc strays in 2 s that precesses about a ball joint at 200 rad/s, leaning by 30 degrees."""
    here = world(substeps=substeps)
    anchor = here.add_body(rapier.RigidBody.fixed(), [])
    start, half = centre(200.0, 0.0), TILT / 2
    build = solid(1.0, TOP, (0.0, 0.0, 0.0)).position(
        at(tuple(start.tolist()), rapier.Rotation3(math.cos(half), 0.0, math.sin(half), 0.0))
    )
    disc = here.add_body(build.angvel(tuple(top_rate(200.0).tolist())).allow_fast_rotation(True), [])
    pin = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_SPHERICAL_AXES)
    here.impulse_joints.insert(anchor, disc, pin.local_frame2(at((0.0, 0.0, -STEM))).build())
    body, off = here.rigid_bodies[disc], 0.0
    v = np.cross(top_rate(200.0), start)
    body.linvel = tuple(v.tolist())
    for step in range(480):
        here.step()
        off = max(off, math.dist(body.translation.to_tuple(), centre(200.0, (step + 1) / 240)))
    return off


@pytest.mark.parametrize("error", [stopped, pinched, swung, shaken, spun, toppled])
def test_what_slides_swings_spins_or_is_pushed_errs_by_the_sub_step_of_which_there_are_four(
    error: Callable[[int], float],
) -> None:
    """By a quarter of what one would; what springs of contacts and single precision add no step takes away."""
    four, eight = error(4), error(8)
    assert error(1) > 3.0 * four
    assert four > 1.6 * eight


def test_a_rod_that_is_pushed_foot_first_errs_by_the_sub_step_and_by_the_springs_of_its_contacts() -> None:
    four = fell_over(4)
    assert fell_over(1) > 2.0 * four
    assert fell_over(4, contact_rate=960.0) < 0.5 * four


def matched(substeps: int) -> float:
    """By how much [rad] a free top of moments 1, 1 and 1.6 kg m2 is turned askew within 10 s, at (.6, 0, 1) rad/s."""
    here = world(0.0, substeps=substeps)
    build = solid(6.0, (1.0, 1.0, 1.6), (0.0, 0.0, 0.0)).angvel((0.6, 0.0, 1.0))
    body, askew = here.rigid_bodies[here.add_body(build, [])], 0.0
    for step in range(2400):
        here.step()
        q = body.rotation
        askew = max(askew, apart((q.w, q.i, q.j, q.k), (step + 1) / 240))
    return askew


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    v, u = a[1:], b[1:]
    return np.array([a[0] * b[0] - v @ u, *(a[0] * u + b[0] * v + np.cross(v, u))])


def about(axis: np.ndarray, angle: float) -> np.ndarray:
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])


def apart(q: Sequence[float], time: float) -> float:
    """By how much [rad] that top is turned otherwise than it should be: it precesses at L/I and spins at (1 - J/I) w3."""
    momentum = np.array([0.6, 0.0, 1.6])
    size = float(np.linalg.norm(momentum))
    due = product(about(momentum / size, size * time), about(np.array([0.0, 0.0, 1.0]), -0.6 * time))
    return 2 * math.acos(min(1.0, abs(float(due @ np.array(q))) / float(np.linalg.norm(q))))


def turned_in_double(substeps: int, keeps: bool) -> float:
    """The same in double precision: Euler's step of L in the body, brought back to the length of L or not, then the turn."""
    moments, q, w = np.array([1.0, 1.0, 1.6]), np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.6, 0.0, 1.0])
    askew, h = 0.0, 1 / 240 / substeps
    for step in range(2400 * substeps):
        # w in the body; its turn by h about itself leaves it as it is there.
        before = moments * w
        after = before - np.cross(w, before) * h
        w = after * (np.linalg.norm(before) / np.linalg.norm(after) if keeps else 1.0) / moments
        speed = float(np.linalg.norm(w))
        q = product(q, about(w / speed, speed * h))
        if (step + 1) % substeps == 0:
            askew = max(askew, apart(q.tolist(), (step + 1) * h))
    return askew


def test_a_free_top_keeps_the_size_of_its_momentum_and_single_precision_takes_what_sub_steps_gain() -> None:
    assert turned_in_double(1, keeps=False) > 2.0 * turned_in_double(1, keeps=True)
    assert matched(1) == pytest.approx(turned_in_double(1, keeps=True), rel=0.3)
    assert turned_in_double(4, keeps=True) < 1.1e-3 < 4e-3 < matched(4) < 6e-3
    assert matched(8) > 2.0 * matched(4)


# Friction of what spins


def rubbed(turn: float) -> tuple[float, float]:
    """Most error [rad/s] of the angular velocity of a stool on four round feet while friction brakes it, and from then on.

    Args: turn: of its feet about the upright [rad].
    """
    here, brake = world(), 0.3 * G * 0.2 / 0.02
    floor(here, 0.3)
    feet = [
        ball(0.02, 0.3).position(at((0.2 * math.cos(turn + angle), 0.2 * math.sin(turn + angle), -0.05)))
        for angle in (math.pi, 0.0, -math.pi / 2, math.pi / 2)
    ]
    moments = (0.01 + 0.03**2 / 3, 0.01 + 0.03**2 / 3, 0.02)
    stool = here.add_body(solid(1.0, moments, (0.0, 0.0, 0.07)).angvel((0.0, 0.0, 10.0)).gyroscopic_forces(False), feet)
    off = [0.0, 0.0]
    for step in range(360):
        here.step()
        due = max(0.0, 10.0 - brake * (step + 1) / 240)
        stopped = due == 0.0
        off[stopped] = max(off[stopped], math.dist(here.rigid_bodies[stool].angvel.to_tuple(), (0.0, 0.0, due)))
    return off[0], off[1]


def test_feet_that_slide_in_a_circle_rub_along_their_slip_from_the_first_step_to_the_last() -> None:
    """A step's friction is .12 rad/s, a sub-step's .03: contacts are known before they touch, and none is lost."""
    for turn in (0.0, 0.4, math.pi / 4):
        braked, after = rubbed(turn)
        assert braked < 3e-3
        assert after < 4e-3


# Continuous collision


def foreseeing(here: rapier.PhysicsWorld, sub_steps: int | None) -> rapier.PhysicsWorld:
    """No body is told of continuous collision. Args: sub_steps: of it in a step, None as it comes, which is one."""
    if sub_steps is not None:
        here.integration_parameters.max_ccd_substeps = sub_steps
    return here


def passed(sub_steps: int | None) -> float:
    """The share of 32 balls of 50 mm at 50 m/s that end behind a wall of a centimetre, each at another phase of the step."""
    here = foreseeing(world(0.0), sub_steps)
    here.add_body(rapier.RigidBody.fixed().position(at((0.005, 0.0, 0.0))), [rapier.Collider.cuboid(0.005, 99.0, 0.5)])
    balls = []
    for k in range(32):
        start = (-0.1 - k / 32 * 50 / 240, float(k), 0.0)
        build = solid(1.0, (1e-3,) * 3, start).linvel((50.0, 0.0, 0.0))
        balls.append(here.add_body(build, [ball(0.05)]))
    for _ in range(60):
        here.step()
    return sum(here.rigid_bodies[each].translation.x > 0 for each in balls) / len(balls)


def spun_through(sub_steps: int | None) -> float:
    """The share of 32 rods at 60 rad/s that turn on through two posts, each at another phase of the step."""
    here, meeting = foreseeing(world(0.0), sub_steps), math.asin(0.02 / 0.4)
    for side in (-0.4, 0.4):
        here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.capsule_z(5.0, 0.01).position(at((side, 0.0, 0.0)))])
    rods = []
    for k in range(32):
        half = -(meeting + 0.15 + k / 32 * 60 / 240) / 2
        turn = rapier.Rotation3(math.cos(half), 0.0, 0.0, math.sin(half))
        build = solid(0.5, (1e-4, 0.04, 0.04), (0.0, 0.0, 0.1 * k)).position(at((0.0, 0.0, 0.1 * k), turn))
        build = build.angvel((0.0, 0.0, 60.0))
        rods.append(here.add_body(build, [rapier.Collider.capsule_x(0.5, 0.01).density(0.0)]))
    for _ in range(60):
        here.step()
    turned = [here.rigid_bodies[rod].rotation for rod in rods]
    # What is held lies at a negative angle, short of the posts.
    return sum(math.sin(2 * math.atan2(q.k, q.w)) > -0.04 for q in turned) / len(rods)


def sunk(sub_steps: int | None, edges_push: bool = True) -> float:
    """The share of 64 balls of 50 mm that fall at 20 m/s, and slide at 1 m/s, through a slab of triangles of a centimetre.

    Args: edges_push: as it comes; else inner edges of the mesh are told not to.
    """
    here, draw, cell, columns, rows = foreseeing(world(), sub_steps), np.random.default_rng(0), 0.25, 6, 67
    grid = [(cell * (i - 1), cell * (j - 1)) for j in range(rows) for i in range(columns)]
    corners, faces = [(x, y, z) for z in (0.0, -0.01) for x, y in grid], []
    for j in range(rows - 1):
        for i in range(columns - 1):
            a, b = i + j * columns, i + (j + 1) * columns
            for p, q, r in ((a, a + 1, b + 1), (a, b + 1, b)):
                faces += [(p, q, r), (p + len(grid), r + len(grid), q + len(grid))]
    flags = None if edges_push else rapier.TriMeshFlags.FIX_INTERNAL_EDGES
    slab = rapier.Collider.trimesh(np.array(corners, dtype=np.float32), np.array(faces, dtype=np.uint32), flags)
    here.add_body(rapier.RigidBody.fixed(), [slab.friction(0.0)])
    balls = []
    for k in range(64):
        start = (draw.uniform(0.0, cell), cell * (k + (0.37 if k % 2 else 0.0)), 0.45 + draw.uniform(0.0, 20 / 60))
        build = solid(1.0, (1e-3,) * 3, start).linvel((1.0, 0.0, -20.0)).gyroscopic_forces(False)
        balls.append(here.add_body(build, [ball(0.05)]))
    for _ in range(120):
        here.step()
    return sum(here.rigid_bodies[each].translation.z < 0.0 for each in balls) / len(balls)


@pytest.mark.parametrize("share", [passed, spun_through])
def test_continuous_collision_against_what_stands_still_is_on_as_it_comes(share: Callable[[int | None], float]) -> None:
    assert share(0) > 0.3
    assert share(None) == share(1) == 0.0


def test_of_a_mesh_inner_edges_let_balls_through_that_continuous_collision_holds() -> None:
    assert rapier.IntegrationParameters().max_ccd_substeps == 1
    assert 0.0 < sunk(None) < 0.15 < sunk(0)
    assert sunk(None, edges_push=False) == 0.0


# Rays


def met(shape: str, gap: float, scale: float = 1.0, rays: int = 400) -> float:
    """The share of rays that meet a solid which they pass at `gap` [m], from 6 m off, all lengths being times `scale`.

    Args: shape: 'cylinder' of 1.4 m by .35 m, past its rims; 'capsule', past its ends; 'cuboid', past its edges.
    """
    here, draw, found, half, wide = world(), np.random.default_rng(1), 0, 0.7, 0.35
    build = getattr(rapier.Collider, {"capsule": "capsule_y"}.get(shape, shape))
    sizes = [wide, half, wide] if shape == "cuboid" else [half, wide]
    here.add_body(rapier.RigidBody.fixed(), [build(*(scale * size for size in sizes))])
    here.update_query_pipeline()
    for _ in range(rays):
        turn, lift = draw.uniform(0.0, 2 * math.pi), draw.uniform(0.05, math.pi / 2 - 0.05)
        out, up = np.array([math.cos(turn), 0.0, math.sin(turn)]), np.array([0.0, draw.choice([-1.0, 1.0]), 0.0])
        if shape == "cuboid":
            out = np.array([math.copysign(1.0, out[0]), 0.0, 0.0])
        normal = math.cos(lift) * out + math.sin(lift) * up
        end = half * up + wide * (normal if shape == "capsule" else out)
        way = np.cross(normal, draw.normal(size=3))
        way /= np.linalg.norm(way)
        start = scale * (end + gap * normal - 6.0 * way)
        found += here.query_pipeline.cast_ray(rapier.Ray(tuple(start), tuple(way)), 30.0 * scale, True) is not None
    return found / rays


def test_rays_meet_a_cylinder_that_they_pass_by_millimetres_since_the_iteration_ends_at_a_length_of_its_own() -> None:
    """So they end on it in place of what lies behind it. Of a cylinder a hundred times as large they err by a hundredth."""
    assert met("cylinder", 1e-3) > 0.2
    assert met("cylinder", 0.02) == 0.0
    assert met("cylinder", 1e-3, scale=100.0) == 0.0
    for shape in ("capsule", "cuboid"):
        assert met(shape, 1e-5) == 0.0


# Springs


def settled(rate: float | None, seconds: float = 1.0) -> float:
    """The way [m] that the top of a pyramid of six bricks goes. Args: rate: of its contacts [Hz], None as they come."""
    here = world()
    if rate is not None:
        spring = rapier.SpringCoefficients(rate, 10.0)
        here.integration_parameters.contact_softness = here.integration_parameters.static_contact_softness = spring
    floor(here, 0.5)
    top = 0
    for row in range(3):
        for k in range(3 - row):
            shape = rapier.Collider.cuboid(0.1, 0.1, 0.05).density(0.0).friction(0.5)
            build = solid(1.0, (0.0125 / 3, 0.0125 / 3, 0.02 / 3), (0.22 * (k - (2 - row) / 2), 0.0, 0.05 * (2 * row + 1)))
            top = here.add_body(build.can_sleep(True), [shape])
    for _ in range(round(240 * seconds)):
        here.step()
    return math.dist(here.rigid_bodies[top].translation.to_tuple(), (0.0, 0.0, 0.25))


def test_a_pyramid_sinks_into_its_springs_by_a_millimetre_and_hardly_where_they_are_stiff() -> None:
    assert 5e-4 < settled(None) < 2e-3
    assert settled(240.0) < settled(None) / 10


# Chance, and roundings


def heated(seed: int) -> float:
    """The share of its energy that a gas of 216 elastic balls in a free box of 500 kg wins in a second, or loses."""
    here, inner, wall = world(0.0), 0.75, 0.1
    moment = 500.0 * 2 / 3 * (inner + wall) ** 2
    walls = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            half, middle = [inner + 2 * wall] * 3, [0.0] * 3
            half[axis], middle[axis] = wall, side * (inner + wall)
            walls.append(rapier.Collider.cuboid(*half).position(at(middle)).density(0.0).friction(0.0).restitution(1.0))
    box = here.add_body(solid(500.0, (moment,) * 3, (0.0, 0.0, 0.0)).gyroscopic_forces(False), walls)
    drawn = np.random.default_rng(seed).standard_normal((216, 3))
    drawn -= drawn.mean(axis=0)
    drawn /= np.sqrt(np.mean(np.sum(drawn**2, axis=1)))
    balls = [(500.0, here.rigid_bodies[box])]
    for k, v in enumerate(drawn.tolist()):
        start = [0.25 * (n + 0.5) - inner for n in (k // 36, k // 6 % 6, k % 6)]
        build = solid(1.0, (1e-3,) * 3, (start[0], start[1], start[2])).linvel(tuple(v)).gyroscopic_forces(False)
        balls.append((1.0, here.rigid_bodies[here.add_body(build, [ball(0.05, restitution=1.0)])]))

    energies = []
    for _ in range(240):
        energies.append(sum(m * math.dist(each.linvel.to_tuple(), (0.0,) * 3) ** 2 for m, each in balls))
        here.step()
    return abs(float(np.polyfit(np.arange(240) / 240, np.array(energies) / energies[0], 1)[0]))


def test_how_much_energy_a_gas_wins_is_chance() -> None:
    won = [heated(seed) for seed in range(8)]
    assert max(won) > 10 * min(won)
    assert sorted(won)[4] > 3e-3


def rebounded(heavy: float, gap: float) -> float:
    """By how much [m/s] a ball of a kilogram errs, by Newton's law, that meets another at 1 m/s, e = .5."""
    here = world(0.0)
    light = here.add_body(solid(1.0, (4e-3,) * 3, (0.0, 0.0, 0.0)).linvel((1.0, 0.0, 0.0)), [ball(0.1, restitution=0.5)])
    here.add_body(solid(heavy, (4e-3 * heavy,) * 3, (0.2 + gap, 0.0, 0.0)), [ball(0.1, restitution=0.5)])
    for _ in range(48):
        here.step()
    return abs(here.rigid_bodies[light].linvel.x - (1.0 - 0.5 * heavy) / (1.0 + heavy))


def led(substeps: int) -> float:
    """By how much [m] a body that is led at 1.5 m/s is off its place within .2 s."""
    here = world(substeps=substeps)
    body = here.rigid_bodies[here.add_body(rapier.RigidBody.kinematic_velocity_based().linvel((1.5, 0.0, 0.0)), [])]
    off = 0.0
    for step in range(48):
        here.step()
        off = max(off, abs(body.translation.x - 1.5 * (step + 1) / 240))
    return off


def leaned() -> float:
    """The tilt [rad] of a box of .2 m that has lain on the ground for 3 s."""
    here = world()
    floor(here)
    shape = rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0).friction(0.0)
    box = here.add_body(solid(1.0, (1 / 150,) * 3, (0.0, 0.0, 0.1)).can_sleep(True), [shape])
    for _ in range(720):
        here.step()
    q = here.rigid_bodies[box].rotation
    return 2 * math.hypot(q.i, q.j)


def test_head_on_pairs_depths_and_the_tilt_of_what_lies_differ_by_roundings_of_single_precision() -> None:
    """One is 6e-8 of 1 m/s, and of the metre."""
    assert max(rebounded(heavy, 0.02 + 1e-3 * k) for heavy in (1.0, 10.0, 1000.0) for k in range(5)) < 2e-6
    assert 6e-8 < led(4) < 2e-6
    assert leaned() < 2e-6
