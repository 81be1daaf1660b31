"""Two floating bodies that a hinge turns, in pybullet's own words: reduced coordinates lose momentum by the turn of a step."""

import numpy as np
import pytest

from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

ARM, SPIN = 0.5, 5.0
"""From the hinge, at the centre of the one, to the centre of the other [m]; how fast the other turns about it [rad/s]."""


def lost(rate: int) -> float:
    """The share of momentum that changes within a second, with no force from outside."""
    with World() as world:
        world.setPhysicsEngineParameter(fixedTimeStep=1 / rate)
        machine = world.createMultiBody(
            1.0,
            linkMasses=[1.0],
            linkCollisionShapeIndices=[-1],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0, 0, 0]],
            linkOrientations=[[0, 0, 0, 1]],
            linkInertialFramePositions=[[ARM, 0, 0]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_REVOLUTE],
            linkJointAxis=[[0, 1, 0]],
        )
        world.release(machine, MULTIBODY)
        for link in (-1, 0):
            world.changeDynamics(machine, link, localInertiaDiagonal=[1 / 150] * 3)
        world.changeDynamics(machine, 0, jointDamping=0.0)
        world.setJointMotorControl2(machine, 0, pybullet.VELOCITY_CONTROL, force=0.0)
        world.resetJointState(machine, 0, 0.0, SPIN)

        def momentum() -> np.ndarray:
            link = world.getLinkState(machine, 0, computeLinkVelocity=1, computeForwardKinematics=1)
            return np.array(world.getBaseVelocity(machine)[0]) + np.array(link[6])

        start, worst = momentum(), 0.0
        for _ in range(rate):
            world.stepSimulation()
            worst = max(worst, float(np.linalg.norm(momentum() - start)))
        return worst / float(np.linalg.norm(start))


@pytest.mark.parametrize("rate", [240, 480, 960])
def test_momentum_is_off_by_the_turn_of_one_step(rate: int) -> None:
    assert lost(rate) == pytest.approx(SPIN / rate, rel=1e-3)
