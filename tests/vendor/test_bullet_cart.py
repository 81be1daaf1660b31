"""A cart of four driven wheels that steers by skidding, on Bullet's own motors and on torques, in pybullet's own words."""

import math

import numpy as np
import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

RADIUS, CHASSIS, WHEEL, FRICTION = 0.1, 10.0, 1.0, 0.8
MASS = CHASSIS + 4 * WHEEL
DAMPING = 20.0
"""Of a torque d (u - x') on each wheel [N m s/rad]: d dt/I = 21 at 1/240 s, where 2 is the most that a held torque bears."""


def cart(world: World) -> int:
    """On a slab, without damping, its motors off."""
    world.setGravity(0, 0, -9.81)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[20, 20, 0.5])
    world.changeDynamics(world.createMultiBody(0.0, slab, basePosition=[0, 0, -0.5]), -1, lateralFriction=1.0)
    ball, at = (
        world.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS),
        [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)],
    )
    made: int = world.createMultiBody(
        baseMass=CHASSIS,
        baseCollisionShapeIndex=-1,
        basePosition=[0, 0, 0.15],
        linkMasses=[WHEEL] * 4,
        linkCollisionShapeIndices=[ball] * 4,
        linkVisualShapeIndices=[-1] * 4,
        linkPositions=[[x, y, RADIUS - 0.15] for x, y in at],
        linkOrientations=[[0, 0, 0, 1]] * 4,
        linkInertialFramePositions=[[0, 0, 0]] * 4,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 4,
        linkParentIndices=[0] * 4,
        linkJointTypes=[pybullet.JOINT_REVOLUTE] * 4,
        linkJointAxis=[[0, 1, 0]] * 4,
    )
    world.release(made, 0)
    moments = [CHASSIS / 3 * (a * a + b * b) for a, b in ((0.2, 0.05), (0.3, 0.05), (0.3, 0.2))]
    world.changeDynamics(made, -1, mass=CHASSIS, localInertiaDiagonal=moments)
    for k in range(4):
        inertia = [0.4 * WHEEL * RADIUS**2] * 3
        world.changeDynamics(made, k, mass=WHEEL, localInertiaDiagonal=inertia, lateralFriction=FRICTION, jointDamping=0.0)
        world.setJointMotorControl2(made, k, pybullet.VELOCITY_CONTROL, force=0)
    return made


def drive(world: World, by: str, left: float, right: float, dt: float) -> tuple[float, float]:
    """The greatest momentum [N s] within 1 s, and the chassis' last yaw rate [rad/s]; wheels are told these rates [rad/s]."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    made, links, wanted, most = cart(world), [0, 1, 2, 3], np.array([left, right, left, right]), 0.0
    for _ in range(round(1 / dt)):
        if by == "motor":
            given = {"targetVelocities": wanted.tolist(), "forces": [1e9] * 4}
            world.setJointMotorControlArray(made, links, pybullet.VELOCITY_CONTROL, **given)
        else:
            rates = np.array([state[1] for state in world.getJointStates(made, links)])
            torques = DAMPING * (wanted - rates)
            world.setJointMotorControlArray(made, links, pybullet.TORQUE_CONTROL, forces=torques.tolist())
        world.stepSimulation()
        wheels = [np.array(link[6]) for link in world.getLinkStates(made, links, computeLinkVelocity=1)]
        momentum = float(np.linalg.norm(CHASSIS * np.array(world.getBaseVelocity(made)[0]) + WHEEL * np.sum(wheels, axis=0)))
        most = max(most, momentum if math.isfinite(momentum) else math.inf)
    return most, float(world.getBaseVelocity(made)[1][2])


TURNS = pytest.mark.parametrize(("left", "right"), [(5.0, 10.0), (-10.0, 10.0)])


@TURNS
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
def test_on_bullets_own_motors_it_goes_no_faster_than_its_wheels_roll(
    world: World, left: float, right: float, dt: float
) -> None:
    momentum, yaw = drive(world, "motor", left, right, dt)
    assert momentum < MASS * right * RADIUS
    assert yaw > 0.1
    print(f"motor at {dt:.4f} s: momentum {momentum:.3g} N s, {yaw:.3g} rad/s")


@TURNS
def test_on_torques_of_the_start_of_a_step_it_bursts(world: World, left: float, right: float) -> None:
    momentum, _ = drive(world, "torque", left, right, 1 / 240)
    assert momentum > 1e3 * MASS * right * RADIUS
