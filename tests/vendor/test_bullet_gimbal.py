"""A wheel in a gimbal on Bullet, on links and on a constraint, in pybullet's own words."""

import math

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

LEAN = pybullet.getQuaternionFromEuler([0, spinning.GIMBAL_TILT, 0])
AXIS = np.array([math.sin(spinning.GIMBAL_TILT), 0.0, math.cos(spinning.GIMBAL_TILT)])


def gimbal(world: World, wheel: str) -> tuple[int, int]:
    """Rings and wheel on links, or the wheel a free body that two points of its axis hold to the inner ring: their numbers."""
    count = 3 if wheel == "link" else 2
    made = world.createMultiBody(
        baseMass=0.0,
        linkMasses=[0.04, 0.03, 0.3][:count],
        linkCollisionShapeIndices=[-1] * count,
        linkVisualShapeIndices=[-1] * count,
        linkPositions=[[0, 0, 0]] * count,
        linkOrientations=[[0, 0, 0, 1], LEAN, [0, 0, 0, 1]][:count],
        linkInertialFramePositions=[[0, 0, 0]] * count,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * count,
        linkParentIndices=[0, 1, 2][:count],
        linkJointTypes=[pybullet.JOINT_REVOLUTE] * count,
        linkJointAxis=[[1, 0, 0], [0, 1, 0], [0, 0, 1]][:count],
    )
    world.release(made, MULTIBODY)
    for k, (mass, moments) in enumerate(zip([0.04, 0.03, 0.3][:count], (*spinning.RINGS, spinning.WHEEL), strict=False)):
        world.changeDynamics(made, k, mass=mass, localInertiaDiagonal=list(moments), jointDamping=0.0)
        world.setJointMotorControl2(made, k, pybullet.VELOCITY_CONTROL, force=0)
        world.resetJointState(made, k, 0.0, spinning.RATES[k])
    if wheel == "link":
        return made, 2
    free = world.createMultiBody(0.3, baseOrientation=LEAN)
    world.changeDynamics(free, -1, mass=0.3, localInertiaDiagonal=list(spinning.WHEEL))
    world.release(free, MULTIBODY)
    world.resetBaseVelocity(free, [0, 0, 0], (np.array([*spinning.RATES[:2], 0.0]) + spinning.SPIN * AXIS).tolist())
    for z in (-0.05, 0.05):
        pin = world.createConstraint(free, -1, made, 1, pybullet.JOINT_POINT2POINT, [0, 0, 0], [0, 0, z], [0, 0, z])
        world.changeConstraint(pin, maxForce=1e12)
    return made, free


def kept(world: World, wheel: str, dt: float) -> tuple[float, float]:
    """The least and the greatest share of its energy within 2 s."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    made, free = gimbal(world, wheel)

    def energy() -> float:
        states = list(world.getLinkStates(made, [0, 1, 2][: 3 if wheel == "link" else 2], 1, 1))
        turns, rates = [state[1] for state in states], [np.array(state[7]) for state in states]
        if wheel != "link":
            turns.append(world.getBasePositionAndOrientation(free)[1])
            rates.append(np.array(world.getBaseVelocity(free)[1]))
        return spinning.gimbal_energy([np.array(pybullet.getMatrixFromQuaternion(q)).reshape(3, 3) for q in turns], rates)

    start, shares = energy(), []
    for _ in range(round(2 / dt)):
        world.stepSimulation()
        shares.append(energy() / start)
    return min(shares), max(share if math.isfinite(share) else math.inf for share in shares)


@pytest.mark.parametrize("dt", [1 / 240, 1e-3, 2.5e-4])
def test_on_links_the_wheels_wobble_takes_energy_from_nowhere(world: World, dt: float) -> None:
    # A wobble at 147 rad/s grows by e^(W^2 dt/2) a second: e^2.7 at the finest of these steps, of a thousandth of the energy.
    _, most = kept(world, "link", dt)
    print(f"links at {dt:.5f} s: {most:.3g} times its energy")
    assert most > 2.0


@pytest.mark.parametrize("dt", [1 / 240, 1 / 960, 2.5e-4])
def test_on_a_constraint_the_wheel_keeps_its_energy(world: World, dt: float) -> None:
    least, most = kept(world, "constraint", dt)
    print(f"constraint at {dt:.5f} s: {least:.5g} to {most:.5g} times its energy")
    assert 0.999 < least <= most < 1.001
