"""What Rapier's adapter declares of joints, of bodies that are led, spin or sleep, in rapier3d's own words."""

import math

import numpy as np
import pytest

from tests.vendor.rapier_world import STILL, G, rapier, solid, world

pytestmark = pytest.mark.rapier
AXIS = rapier.JointAxis
ACROSS = rapier.Rotation3(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


def joined(
    reduced: bool, joint: rapier.GenericJointBuilder, mass: float = 1.0, rate: float = 0.0
) -> tuple[rapier.PhysicsWorld, int]:
    """A body of moments 0.1 kg m2 on a joint with the world, and its handle. Args: rate: of a hinge at the start [rad/s]."""
    here = world(0.0)
    anchor = here.add_body(rapier.RigidBody.fixed(), [])
    build = solid(mass, (0.1,) * 3, (0.0, 0.0, 0.0))
    body = here.add_body(build if reduced else build.angvel((rate, 0.0, 0.0)), [])
    handle = (here.multibody_joints if reduced else here.impulse_joints).insert(anchor, body, joint.build())
    if reduced:
        tree = here.multibody_joints.multibody(handle)
        tree.set_damping([0.0] * tree.ndofs)
        # The root counts as one that stands still from the first step on.
        here.integration_parameters.dt = 1e-9
        here.step()
        here.integration_parameters.dt = 1 / 240
        here.multibody_joints.multibody(handle).set_generalized_velocity([rate])
    return here, body


def turned_to(here: rapier.PhysicsWorld, body: int, steps: int) -> float:
    """The angle [rad] that a body turned by, turns counted."""
    angle = 0.0
    for _ in range(steps):
        here.step()
        angle += here.rigid_bodies[body].angvel.x / 240
    return angle


@pytest.mark.parametrize(
    ("low", "high", "holds"), [(-1.0, 2.0, True), (-1.0, 5.0, True), (-1.0, 8.0, False), (-8.0, 8.0, False)]
)
def test_limits_of_a_hinge_further_apart_than_a_turn_hold_in_reduced_coordinates_alone(
    low: float, high: float, holds: bool
) -> None:
    """6 rad/s for 3 s: 18 rad without a stop."""
    hinge = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES).limits(AXIS.ANG_X, low, high)
    assert turned_to(*joined(True, hinge, rate=6.0), 720) == pytest.approx(high, abs=2e-2)
    assert turned_to(*joined(False, hinge, rate=6.0), 720) == pytest.approx(high if holds else 18.0, abs=2e-2)


def beyond_the_stop(start: float, gap: float) -> float:
    """By how much [rad] a rod that falls from `start` off hanging passes a stop at 20 degrees.

    Args: gap: between that stop and the one on the other side, modulo a turn [rad]."""
    here, stop = world(), math.radians(20.0) - start
    anchor, p = here.add_body(rapier.RigidBody.fixed(), []), (0.0, 0.5 * math.sin(start), -0.5 * math.cos(start))
    rod = here.add_body(solid(1.0, (1 / 12,) * 3, p), [])
    hinge = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    limited = hinge.limits(AXIS.ANG_X, stop, stop + 2 * math.pi - gap)
    far = rapier.Isometry3(tuple(-x for x in p), STILL)
    here.impulse_joints.insert(anchor, rod, limited.local_frame2(far).build())
    lowest = 0.0
    for _ in range(720):
        here.step()
        at = here.rigid_bodies[rod].translation
        lowest = min(lowest, math.atan2(at.y, -at.z) - start)
    return stop - lowest


def test_a_stop_of_an_impulse_joint_is_lost_where_the_other_is_a_milliradian_less_than_a_turn_away() -> None:
    starts = [math.radians(degrees) for degrees in range(60, 120, 4)]
    assert max(beyond_the_stop(start, 1e-3) for start in starts) > 0.1
    assert max(beyond_the_stop(start, 0.25) for start in starts) < 2e-2


@pytest.mark.parametrize("target", [3.0, 4.0, 8.0])
def test_a_motor_aims_beyond_half_a_turn_in_reduced_coordinates_alone(target: float) -> None:
    hinge = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES)
    driven = hinge.motor_model(AXIS.ANG_X, rapier.MotorModel.FORCE_BASED).motor(AXIS.ANG_X, target, 0.0, 1.0, 0.3)
    assert turned_to(*joined(True, driven), 4800) == pytest.approx(target, abs=2e-2)
    short = (target + math.pi) % (2 * math.pi) - math.pi
    assert turned_to(*joined(False, driven), 4800) == pytest.approx(short, abs=2e-2)


@pytest.mark.parametrize("reduced", [True, False])
@pytest.mark.parametrize("pull", [2.0, 5.0])
def test_a_motor_towards_rest_that_is_cut_off_is_coulomb_friction_and_nothing_else_is(reduced: bool, pull: float) -> None:
    """Args: pull: on 2 kg [N], against 3 N."""
    slide = rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_PRISMATIC_AXES).motor_model(
        AXIS.LIN_X, rapier.MotorModel.FORCE_BASED
    )
    here, body = joined(reduced, slide.motor(AXIS.LIN_X, 0.0, 0.0, 0.0, 1e9).motor_max_force(AXIS.LIN_X, 3.0), mass=2.0)
    for _ in range(480):
        here.rigid_bodies[body].reset_forces(True)
        here.rigid_bodies[body].add_force((pull, 0.0, 0.0), True)
        here.step()
    assert here.rigid_bodies[body].linvel.x == pytest.approx(max(0.0, pull - 3.0) / 2.0 * 2.0, abs=3e-3)
    kinds = (rapier.GenericJoint, rapier.ImpulseJoint, rapier.Multibody, rapier.JointMotor)
    assert not [name for kind in kinds for name in dir(kind) if "friction" in name]


def test_a_body_told_without_moments_never_turns() -> None:
    """Neither a mass alone nor moments of 0 are a point: both are taken for endless moments."""
    here = world(0.0)
    none = rapier.MassProperties((0.0, 0.0, 0.0), 2.0, (0.0, 0.0, 0.0), STILL)
    start = rapier.RigidBody.dynamic().can_sleep(False)
    bodies = [here.add_body(start.additional_mass(2.0), [])]
    bodies.append(here.add_body(rapier.RigidBody.dynamic().can_sleep(False).additional_mass_properties(none), []))
    for body in bodies:
        here.rigid_bodies[body].add_torque((1.0, 0.0, 0.0), True)
        here.rigid_bodies[body].add_force((1.0, 0.0, 0.0), True)
    for _ in range(240):
        here.step()
    assert [here.rigid_bodies[body].angvel.to_tuple() for body in bodies] == [(0.0, 0.0, 0.0)] * 2
    assert [here.rigid_bodies[body].linvel.x for body in bodies] == pytest.approx([0.5] * 2, rel=1e-4)


def swings(mass: float | None) -> tuple[float, ...]:
    """Where [m] a bob of 1 kg on two crossed hinges is after a second. Args: mass: of the body between them; None: not told."""
    here = world()
    anchor, start = here.add_body(rapier.RigidBody.fixed(), []), (0.6, 0.48, -0.64)
    build = rapier.RigidBody.dynamic().can_sleep(False)
    if mass is not None:
        build = build.additional_mass_properties(rapier.MassProperties((0.0, 0.0, 0.0), mass, (mass,) * 3, STILL))
    between, bob = here.add_body(build, []), here.add_body(solid(1.0, (0.1,) * 3, start), [])
    first, second = (rapier.GenericJoint.builder(rapier.JointAxesMask.LOCKED_REVOLUTE_AXES) for _ in range(2))
    second = second.local_frame1(rapier.Isometry3((0.0, 0.0, 0.0), ACROSS))
    second = second.local_frame2(rapier.Isometry3(tuple(-x for x in start), ACROSS))
    here.multibody_joints.insert(anchor, between, first.build())
    handle = here.multibody_joints.insert(between, bob, second.build())
    tree = here.multibody_joints.multibody(handle)
    tree.set_damping([0.0] * tree.ndofs)
    for _ in range(240):
        here.step()
    assert here.quarantine.is_empty
    return here.rigid_bodies[bob].translation.to_tuple()


def test_a_link_of_a_multibody_may_have_no_mass() -> None:
    """Without it the bob moves as the limit of lighter and lighter links, which are taken for what they weigh."""
    assert swings(None) == swings(0.0)
    light, heavier = (math.dist(swings(mass), swings(None)) for mass in (1e-4, 1e-2))
    assert light < 3e-5
    assert 50 < heavier / light < 200


MOMENTS = (0.1, 0.2, 0.25)


def spun(moments: tuple[float, float, float], substeps: int, gyroscopic: bool = True) -> float:
    """What a free top gains of its energy in each sub-step of a second of steps of 1/3840 s."""
    here = world(0.0, 1 / 3840, substeps)
    body = here.add_body(solid(1.0, moments, (0.0, 0.0, 0.0)).angvel((3.0, 1.0, -2.0)).gyroscopic_forces(gyroscopic), [])

    def energy() -> float:
        q, w = here.rigid_bodies[body].rotation, np.array(here.rigid_bodies[body].angvel.to_tuple())
        u = np.array([q.i, q.j, q.k])
        return float(np.array(moments) @ (w - 2 * q.w * np.cross(u, w) + 2 * np.cross(u, np.cross(u, w))) ** 2)

    before = energy()
    for _ in range(3840):
        here.step()
    return (energy() / before - 1.0) / (3840 * substeps)


@pytest.mark.parametrize("substeps", [1, 4])
def test_gyroscopic_forces_give_a_top_2e_7_of_its_energy_in_each_sub_step_even_a_ball_which_without_them_keeps_it(
    substeps: int,
) -> None:
    assert 1e-7 < spun(MOMENTS, substeps) < 3e-7
    assert 1e-7 < spun((0.1,) * 3, substeps) < 3e-7
    assert abs(spun((0.1,) * 3, substeps, gyroscopic=False)) < 1e-12


def led(how: str, start: float, substeps: int = 12) -> float:
    """How far [m] a body that is led at 0.5 m/s for a second of steps of 1 ms is off."""
    here, position = world(0.0, 1e-3, substeps), how == "position"
    build = rapier.RigidBody.kinematic_position_based() if position else rapier.RigidBody.kinematic_velocity_based()
    handle = here.add_body(build.position(rapier.Isometry3((start, 0.0, 0.0), STILL)).linvel((0.5, 0.0, 0.0)), [])
    for k in range(1000):
        body = here.rigid_bodies[handle]
        if position:
            body.set_next_kinematic_translation((start + 5e-4 * (k + 1), 0.0, 0.0))
        elif how == "put back":
            body.position = rapier.Isometry3((start + 5e-4 * k, 0.0, 0.0), STILL)
        here.step()
    assert here.rigid_bodies[handle].linvel.x == pytest.approx(0.5, abs=1e-3 if position else 1e-9)
    return abs(here.rigid_bodies[handle].translation.x - start - 0.5)


def test_a_body_led_by_velocity_leaves_its_path_and_one_whose_poses_are_told_does_not() -> None:
    """Single precision rounds each of 12 sub-steps: 31 um on 0.5 m near the origin, 3.5 mm nine metres off."""
    assert 2e-5 < led("velocity", 0.0) < 4e-5
    assert 2e-3 < led("velocity", 9.0) < 5e-3
    assert led("velocity", 0.0, 1) < 1e-5
    for start in (0.0, 9.0):
        # A rounding of the last step is left: 12 of half a unit in the last place of 9.5 m.
        assert led("position", start) < 1e-6
        assert led("put back", start) < 6e-6


def slept(v: float, w: float, may: bool = True, touching: bool = False) -> bool:
    """Does a free body at v [m/s] and w [rad/s] sleep within 2 s? Args: touching: does it slide on ice."""
    here = world(G if touching else 0.0)
    box = rapier.Collider.cuboid(0.1, 0.1, 0.1).density(0.0).friction(0.0)
    if touching:
        here.add_body(rapier.RigidBody.fixed(), [rapier.Collider.halfspace((0.0, 0.0, 1.0)).friction(0.0)])
    build = solid(1.0, (0.1,) * 3, (0.0, 0.0, 0.1)).linvel((v, 0.0, 0.0)).angvel((0.0, 0.0, w)).can_sleep(may)
    body = here.add_body(build, [box] if touching else [])
    for _ in range(480):
        here.step()
    return bool(here.rigid_bodies[body].is_sleeping)


@pytest.mark.parametrize("touching", [False, True])
def test_what_is_slower_than_a_tenth_of_a_metre_a_second_is_put_to_sleep_on_its_way(touching: bool) -> None:
    """In empty space too. The threshold reads .05, and is of half a second's way: 0.1 m/s; none is awake for being told so."""
    assert [slept(v, 0.0, touching=touching) for v in (0.005, 0.09, 0.11)] == [True, True, False]
    if not touching:
        assert [slept(0.0, w) for w in (0.49, 0.51)] == [True, False]
    assert not slept(0.005, 0.0, may=False, touching=touching)


@pytest.mark.parametrize("word", ["tendon", "pulley", "transmission"])
def test_no_joint_or_multibody_has_such_a_word(word: str) -> None:
    kinds = (rapier, rapier.GenericJoint, rapier.Multibody, rapier.MultibodyJointSet, rapier.ImpulseJointSet)
    assert not [name for kind in kinds for name in dir(kind) if word in name.lower()]
