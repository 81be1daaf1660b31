"""Settings of Rapier that its adapter's tuned track is made of, each beside the vendor's own, in rapier3d's own words."""

import math

import pytest

from tests.vendor.rapier_world import STILL, G, rapier, solid, world

pytestmark = pytest.mark.rapier
MOMENT = 0.4 * 0.2**2


def stiff(here: rapier.PhysicsWorld, ratio: float, in_bias: bool, rate: float = 0.125) -> rapier.PhysicsWorld:
    """Contacts of `rate` times the rate of sub-steps and this damping ratio. Args: in_bias: is friction in the biased pass."""
    told = here.integration_parameters
    spring = rapier.SpringCoefficients(rate * told.num_solver_iterations / told.dt, ratio)
    told.contact_softness = told.static_contact_softness = spring
    told.friction_in_bias_pass, told.contact_recycling = in_bias, False
    return here


def ground(here: rapier.PhysicsWorld, friction: float = 0.5, restitution: float = 0.0) -> None:
    plane = rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(friction).restitution(restitution)
    here.add_body(rapier.RigidBody.fixed(), [plane])


def box(
    here: rapier.PhysicsWorld,
    z: float,
    mass: float = 1.0,
    v: tuple[float, float, float] = (0.0, 0.0, 0.0),
    turned: rapier.Rotation3 = STILL,
) -> int:
    """A cube of 0.2 m."""
    shape = rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0).friction(0.5)
    build = solid(mass, (mass * 0.04 / 6,) * 3, (0.0, 0.0, z)).position(rapier.Isometry3((0.0, 0.0, z), turned))
    return here.add_body(build.linvel(v), [shape])


def slid(in_a_tree: bool, direction: float) -> tuple[float, float]:
    """How far [m] along its way and aside a box slides at 2 m/s whose edges are 0.7 rad off the axes of the world.

    Args: in_a_tree: does a hinge of a multibody hang on the floor.
    """
    here, turned = world(substeps=12), rapier.Rotation3(math.cos(0.35), 0.0, 0.0, math.sin(0.35))
    build = rapier.RigidBody.fixed().position(rapier.Isometry3((0.0, 0.0, -0.5), STILL))
    floor = here.add_body(build, [rapier.Collider.cuboid(5.0, 5.0, 0.5).friction(0.5)])
    x, y = math.cos(direction), math.sin(direction)
    body = box(here, 0.1, v=(2.0 * x, 2.0 * y, 0.0), turned=turned)
    if in_a_tree:
        bob = here.add_body(solid(1.0, (0.1,) * 3, (0.0, 9.0, 3.0)), [])
        hinge = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
        here.multibody_joints.insert(floor, bob, hinge.local_frame1(rapier.Isometry3((0.0, 9.0, 3.5), STILL)).build())
    for _ in range(240):
        here.step()
    p = here.rigid_bodies[body].translation
    return p.x * x + p.y * y, abs(p.y * x - p.x * y)


def test_friction_of_a_floor_that_a_multibody_hangs_on_depends_on_the_direction() -> None:
    """Contacts of links have the friction of 'coulomb'; v^2/(2 mu g) is .4077 m."""
    for direction in (0.0, 0.4, math.pi / 4):
        assert slid(False, direction) == pytest.approx((0.4077, 0.0), abs=1e-3)
    assert slid(True, math.pi / 4)[0] > 1.05 * 0.4077
    assert slid(True, 0.4)[1] > 0.01


def trembles(ratio: float, in_bias: bool) -> float:
    """The speed [m/s] at which a column of five boxes trembles after 4 s, on contacts of a quarter of the rate of sub-steps."""
    here = stiff(world(dt=1 / 720), ratio, in_bias, 0.25)
    ground(here)
    bodies = [box(here, 0.1 + 0.2 * k) for k in range(5)]
    total = 0.0
    for step in range(3600):
        here.step()
        if step >= 2880:
            total += sum(math.dist(here.rigid_bodies[b].linvel.to_tuple(), (0.0,) * 3) ** 2 for b in bodies)
    return math.sqrt(total / 720 / len(bodies))


def test_friction_in_the_biased_pass_shakes_a_column_unless_contacts_are_critically_damped() -> None:
    """The vendor's damping ratio is 10, and its documentation warns of that friction in stacks."""
    assert trembles(10.0, True) > 1e-3
    assert max(trembles(10.0, False), trembles(1.0, True)) < 3e-4


def crept(in_bias: bool) -> float:
    """How far [m] a box on an incline of ten degrees creeps from half a second on, in 2 s."""
    here = stiff(world(dt=1 / 720), 1.0, in_bias)
    lean = math.radians(10.0)
    here.gravity = (G * math.sin(lean), 0.0, -G * math.cos(lean))
    ground(here)
    body, start = box(here, 0.1), 0.0
    for step in range(1800):
        here.step()
        start = here.rigid_bodies[body].translation.x if step == 360 else start
    return here.rigid_bodies[body].translation.x - start


def test_without_friction_in_the_biased_pass_a_box_creeps() -> None:
    assert abs(crept(False)) > 1e-6
    assert abs(crept(True)) < 1e-8


def thrown(prediction: float, height: float) -> float:
    """What friction leaves of 6 m/s along the ground of a ball that comes down at 2 m/s, e = .6, mu = .3."""
    here = stiff(world(0.0, 1 / 720), 1.0, True)
    here.integration_parameters.normalized_prediction_distance = prediction
    ground(here, 0.3, 0.6)
    shape = rapier.Collider.ball(0.2).density(0.0).friction(0.3).restitution(0.6)
    body = here.add_body(solid(1.0, (MOMENT,) * 3, (0.0, 0.0, 0.2 + height)).linvel((6.0, 0.0, -2.0)), [shape])
    for _ in range(360):
        here.step()
    return here.rigid_bodies[body].linvel.x


def test_what_a_throw_keeps_hangs_on_the_phase_of_the_step_where_contacts_are_foreseen_from_2_cm_and_not_from_2_mm() -> None:
    """2 mm is the default in the documentation of `IntegrationParameters`; a new world reads 2 cm."""
    assert rapier.IntegrationParameters().normalized_prediction_distance == pytest.approx(0.02)
    spread = {p: [thrown(p, 0.25 + 7e-4 * k) for k in range(12)] for p in (0.02, 0.002)}
    assert max(spread[0.02]) - min(spread[0.02]) > 0.02
    assert max(spread[0.002]) - min(spread[0.002]) < 0.002


def parted(speed: float, mass: float = 1.0, overlap: float = 0.05) -> tuple[float, float]:
    """Two boxes: the speed [m/s] at which the upper one, inside of the lower at first, rises at most, and how deep it stands.

    Args: speed: the most at which overlaps are corrected [m/s]. mass: of the upper one [kg].
    """
    here = stiff(world(dt=1 / 720), 1.0, True)
    here.integration_parameters.normalized_max_corrective_velocity = speed
    ground(here)
    box(here, 0.1)
    upper, fastest = box(here, 0.3 - overlap, mass), 0.0
    for _ in range(2160):
        here.step()
        fastest = max(fastest, here.rigid_bodies[upper].linvel.z)
    return fastest, 0.3 - here.rigid_bodies[upper].translation.z


def test_what_is_corrected_slowly_parts_quietly_and_bears_no_load() -> None:
    """A sub-step may add the capped speed to the lower box, and its load takes R g h from it, R times its own weight."""
    assert parted(3.0)[0] > 0.5
    assert parted(0.1)[0] < 0.05
    assert parted(3.0, 100.0, 0.0)[1] < 1e-3
    assert parted(0.1, 100.0, 0.0)[1] > 0.05
