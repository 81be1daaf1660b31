"""The motors that pybullet puts on every joint, in pybullet's own words: what a pendulum does as it comes."""

import math

import pytest

from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

ARM, G = 1.0, 9.81


def pendulum(world: World, kind: int, mass: float, dt: float) -> int:
    """A small ball at the end of a level arm [m], on a joint that lets it fall, nothing said of motors."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt)
    world.setGravity(0, 0, -G)
    made: int = world.createMultiBody(
        baseMass=0.0,
        linkMasses=[mass],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[ARM, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[kind],
        linkJointAxis=[[0, 0, 1] if kind == pybullet.JOINT_PRISMATIC else [0, 1, 0]],
    )
    world.release(made, MULTIBODY)
    world.changeDynamics(made, 0, mass=mass, localInertiaDiagonal=[mass * 1e-4] * 3)
    return made


def fallen(world: World, made: int, dt: float, seconds: float) -> float:
    """How far [m] it is from its start."""
    for _ in range(round(seconds / dt)):
        world.stepSimulation()
    return math.dist(world.getLinkState(made, 0, computeForwardKinematics=1)[0], (ARM, 0, 0))


KINDS = pytest.mark.parametrize("kind", [pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC, pybullet.JOINT_SPHERICAL])
HINGES = pytest.mark.parametrize("kind", [pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC])


@KINDS
def test_as_it_comes_a_pendulum_of_a_kilogram_hangs_level_for_a_minute(world: World, kind: int) -> None:
    assert fallen(world, pendulum(world, kind, 1.0, 1 / 240), 1 / 240, 60.0) < 1e-9


@HINGES
@pytest.mark.parametrize("rate", [60, 240, 1000])
def test_the_motor_of_a_hinge_bears_an_impulse_of_one_a_step(world: World, kind: int, rate: int) -> None:
    """1 N m s a step is a torque of 1/dt, 240 N m at 1/240 s and 1000 at 1 ms: a weight of less stays, one of more falls."""
    for share, stays in ((0.99, True), (1.01, False)):
        world.resetSimulation()
        assert (fallen(world, pendulum(world, kind, share * rate / G / ARM, 1 / rate), 1 / rate, 1.0) < 1e-9) == stays


def test_the_motor_of_a_ball_joint_bears_two_tonnes(world: World) -> None:
    """No bound of it was met: 2000 kg at 1 m are 20 kN m, 80 times what a hinge's motor bears at this step."""
    assert fallen(world, pendulum(world, pybullet.JOINT_SPHERICAL, 2000.0, 1 / 240), 1 / 240, 1.0) < 1e-9


def test_a_motor_told_to_bear_nothing_lets_a_pendulum_fall(world: World) -> None:
    made = pendulum(world, pybullet.JOINT_REVOLUTE, 1.0, 1 / 240)
    world.setJointMotorControl2(made, 0, pybullet.VELOCITY_CONTROL, force=0)
    # A quarter of the period of a small swing, 2 pi sqrt(l/g)/4 = 0.5 s, and it is half-way down and more.
    assert fallen(world, made, 1 / 240, 0.5) > ARM / 2
