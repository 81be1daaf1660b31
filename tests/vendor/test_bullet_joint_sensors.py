"""What pybullet's sensors of joints hold: frame, sign, and what of an axis is left out of them."""

import numpy as np
import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

ARM, WEIGHT = 0.8, 9.81


def beam(world: World, joint: int, turn: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)) -> int:
    """A link of 1 kg whose centre of mass lies .8 m along x from its joint to the world, about y; its frame is turned."""
    back = pybullet.invertTransform([0.0] * 3, turn)[1]
    arm, axis = (pybullet.rotateVector(back, v) for v in ([ARM, 0.0, 0.0], [0.0, 1.0, 0.0]))
    world.setGravity(0.0, 0.0, -WEIGHT)
    world.setPhysicsEngineParameter(fixedTimeStep=1e-3)
    number: int = world.createMultiBody(
        baseMass=0.0,
        linkMasses=[1.0],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0.0, 0.0, 1.0]],
        linkOrientations=[turn],
        linkInertialFramePositions=[arm],
        linkInertialFrameOrientations=[[0.0, 0.0, 0.0, 1.0]],
        linkParentIndices=[0],
        linkJointTypes=[joint],
        linkJointAxis=[axis],
    )
    world.release(number, maximal=0)
    world.changeDynamics(number, 0, mass=1.0, localInertiaDiagonal=[0.1] * 3)
    world.enableJointForceTorqueSensor(number, 0, 1)
    return number


def test_the_sensor_holds_what_the_parent_exerts_on_the_link_in_the_frame_of_its_centre_of_mass(world: World) -> None:
    """A weld's force is the weight upwards, in the turned frame; its moment about the centre of mass is none."""
    turn = pybullet.getQuaternionFromEuler([0.3, -0.5, 0.8])
    number = beam(world, pybullet.JOINT_FIXED, turn)
    for _ in range(10):
        world.stepSimulation()
    sensed = np.array(world.getJointState(number, 0)[2])
    R = np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)
    np.testing.assert_allclose(R @ sensed[:3], (0.0, 0.0, WEIGHT), atol=1e-9)
    np.testing.assert_allclose(sensed[3:], 0.0, atol=1e-9)


@pytest.mark.parametrize("by", ["applied torque", "motor", "limit"])
def test_an_applied_torque_is_in_the_sensor_and_those_of_motors_and_limits_are_not(world: World, by: str) -> None:
    """Level at rest the moment about the centre of mass is 0 in all; without the axis' own torque it is that of the weight."""
    number = beam(world, pybullet.JOINT_REVOLUTE)
    world.setJointMotorControl2(number, 0, pybullet.VELOCITY_CONTROL, force=1e3 if by == "motor" else 0.0)
    if by == "limit":
        world.changeDynamics(number, 0, jointLowerLimit=-1.0, jointUpperLimit=0.0, jointLimitForce=1e9)
    for _ in range(200):
        if by == "applied torque":
            world.setJointMotorControl2(number, 0, pybullet.TORQUE_CONTROL, force=-WEIGHT * ARM)
        world.stepSimulation()
    sensed, motor = world.getJointState(number, 0)[2:4]
    np.testing.assert_allclose(sensed[:3], (0.0, 0.0, WEIGHT), atol=1e-6)
    assert sensed[4] == pytest.approx(0.0 if by == "applied torque" else WEIGHT * ARM, abs=1e-6)
    assert motor == pytest.approx(-WEIGHT * ARM if by == "motor" else 0.0, abs=1e-6)


def test_the_sensor_is_of_the_start_of_the_step(world: World) -> None:
    """Level, at 3 rad/s: the centripetal force lies along the beam as it stood before the step.

    Along the beam after the step it would differ by 3e-5 N, and by 2e-2 N across it.
    """
    number = beam(world, pybullet.JOINT_REVOLUTE)
    world.setJointMotorControl2(number, 0, pybullet.VELOCITY_CONTROL, force=0.0)
    world.resetJointState(number, 0, 0.0, 3.0)
    world.stepSimulation()
    assert world.getJointState(number, 0)[2][0] == pytest.approx(-9.0 * ARM, abs=1e-6)
