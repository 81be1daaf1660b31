"""What pybullet's position motor is, in pybullet's own words."""

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet


def one_hinge(world: World, dt: float) -> int:
    """A body of 0.1 kg m2 on a hinge through its centre, its default motor off."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    made: int = world.createMultiBody(
        baseMass=0.0,
        linkMasses=[1.0],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[pybullet.JOINT_REVOLUTE],
        linkJointAxis=[[0, 0, 1]],
    )
    world.changeDynamics(made, -1, linearDamping=0.0, angularDamping=0.0)
    world.changeDynamics(made, 0, mass=1.0, localInertiaDiagonal=[0.1, 0.1, 0.1], jointDamping=0.0)
    world.setJointMotorControl2(made, 0, pybullet.VELOCITY_CONTROL, force=0.0)
    return made


def test_a_position_motor_is_a_velocity_constraint_that_no_load_makes_give_way(world: World) -> None:
    """v' = kp (target - q)/dt + (1 - kd) v + kd v*, whatever the inertia and the load: it has no stiffness in N m/rad."""
    dt, kp = 1 / 60, 0.1
    rates = []
    for load in (0.0, 5.0):
        hinge = one_hinge(world, dt)
        world.setJointMotorControl2(hinge, 0, pybullet.POSITION_CONTROL, targetPosition=1.0, positionGain=kp, force=1e9)
        world.setJointMotorControl2(hinge, 0, pybullet.TORQUE_CONTROL, force=load)
        world.stepSimulation()
        rates.append(world.getJointState(hinge, 0)[1])
    assert rates == pytest.approx([kp * 1.0 / dt] * 2, rel=1e-9)
