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


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_motor_that_asks_for_no_velocity_is_dry_friction(world: World, share: float) -> None:
    """Under a torque of a share of its force the hinge stands, or gets what goes beyond: (share - 1) f t / I exactly."""
    dt, loss, steps = 1 / 240, 0.5, 60
    hinge = one_hinge(world, dt)
    world.setJointMotorControl2(hinge, 0, pybullet.VELOCITY_CONTROL, targetVelocity=0.0, force=loss)
    for _ in range(steps):
        world.setJointMotorControl2(hinge, 0, pybullet.TORQUE_CONTROL, force=share * loss)
        world.stepSimulation()
    assert world.getJointState(hinge, 0)[1] == pytest.approx(max(share - 1, 0) * loss * steps * dt / 0.1, abs=1e-9)


@pytest.mark.parametrize("ratio", [2.0, -0.5])
def test_a_gear_ties_the_first_coordinate_to_minus_its_ratio_times_the_second(world: World, ratio: float) -> None:
    """x = ratio y by gearRatio = -ratio: a torque on x moves I (1 + 1/ratio^2), each wheel having I = 0.1 kg m2."""
    dt, torque, steps = 1e-3, 0.3, 500
    first, second = one_hinge(world, dt), one_hinge(world, dt)
    gear = world.createConstraint(first, 0, second, 0, pybullet.JOINT_GEAR, [0, 0, 1], [0, 0, 0], [0, 0, 0])
    world.changeConstraint(gear, gearRatio=-ratio, maxForce=1e10)
    for _ in range(steps):
        world.setJointMotorControl2(first, 0, pybullet.TORQUE_CONTROL, force=torque)
        world.stepSimulation()
    x, y = (world.getJointState(wheel, 0)[1] for wheel in (first, second))
    # The solver sweeps to 1e-9 of the impulses of 200 iterations.
    assert x == pytest.approx(torque * steps * dt / (0.1 * (1 + 1 / ratio**2)), rel=1e-6)
    assert x == pytest.approx(ratio * y, rel=1e-6)


def test_nothing_gives_a_joint_the_inertia_of_a_rotor(world: World) -> None:
    hinge = one_hinge(world, 1 / 240)
    with pytest.raises(TypeError, match="jointArmature"):
        world.changeDynamics(hinge, 0, jointArmature=0.1)


def test_a_second_mode_of_a_joint_takes_the_place_of_the_first(world: World) -> None:
    """A position that is aimed at is reached, unless the joint is told after it to keep a velocity: it has one motor."""
    angles = []
    for second in (False, True):
        hinge = one_hinge(world, 1 / 240)
        world.setJointMotorControl2(hinge, 0, pybullet.POSITION_CONTROL, targetPosition=1.0, positionGain=0.1, force=1e9)
        if second:
            world.setJointMotorControl2(hinge, 0, pybullet.VELOCITY_CONTROL, targetVelocity=0.0, force=1e9)
        for _ in range(240):
            world.stepSimulation()
        angles.append(world.getJointState(hinge, 0)[0])
    assert angles == pytest.approx([1.0, 0.0], abs=1e-6)
