"""A ball that rolls on a turntable, in pybullet's own words: its circle widens, in first order of the step."""

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

R, RATE, START, DURATION = 0.05, 3.0, 0.5, 4.0
"""Radius of the ball [m], the table's turning [rad/s], where the ball starts [m], and how long it rolls [s]."""
TURN = 2 / 7 * RATE
"""A solid ball goes round at 2/7 of the table's rate, wherever it starts."""
TABLE = (2.0, 2.0, 0.1)
"""Its half extents [m]; its top is at z = 0."""


def astray(rate: int, maximal: int = MULTIBODY) -> float:
    """How far a ball on its circle gets from it at steps of 1/rate s, as a share of the circle's radius."""
    with World() as world:
        world.setPhysicsEngineParameter(
            fixedTimeStep=1 / rate, numSolverIterations=1000, solverResidualThreshold=1e-12, contactSlop=0.0
        )
        world.setGravity(0.0, 0.0, -9.81)
        table = world.createMultiBody(
            0.0,
            basePosition=(0.0, 0.0, -TABLE[2]),
            linkMasses=[1e3],
            linkCollisionShapeIndices=[world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=TABLE)],
            linkVisualShapeIndices=[-1],
            linkPositions=[(0.0, 0.0, 0.0)],
            linkOrientations=[(0.0, 0.0, 0.0, 1.0)],
            linkInertialFramePositions=[(0.0, 0.0, 0.0)],
            linkInertialFrameOrientations=[(0.0, 0.0, 0.0, 1.0)],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_REVOLUTE],
            linkJointAxis=[(0.0, 0.0, 1.0)],
        )
        for link in (-1, 0):
            world.changeDynamics(table, link, linearDamping=0.0, angularDamping=0.0, lateralFriction=1.0)
        world.resetJointState(table, 0, 0.0, RATE)
        world.setJointMotorControl2(table, 0, pybullet.VELOCITY_CONTROL, targetVelocity=RATE, force=1e6)
        ball = world.body(
            world.createCollisionShape(pybullet.GEOM_SPHERE, radius=R), 1.0, (START, 0.0, R), maximal, lateralFriction=1.0
        )
        world.changeDynamics(ball, -1, localInertiaDiagonal=[0.4 * R**2] * 3)
        world.resetBaseVelocity(ball, (0.0, TURN * START, 0.0), (5 / 7 * RATE * START / R, 0.0, 0.0))
        worst = 0.0
        for step in range(1, round(DURATION * rate) + 1):
            world.stepSimulation()
            angle = TURN * step / rate
            right = np.array([START * np.cos(angle), START * np.sin(angle), R])
            worst = max(worst, float(np.linalg.norm(np.array(world.getBasePositionAndOrientation(ball)[0]) - right)))
        return worst / START


def widening(rate: int) -> float:
    """v' = W z x v with the direction of the step's start: speed and circle grow by W^2 dt/2 a second."""
    return TURN**2 / rate / 2 * DURATION


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
@pytest.mark.parametrize(("rate", "share"), [(960, 0.002), (1920, 0.001), pytest.param(7680, 0.0005, marks=pytest.mark.slow)])
def test_its_circle_widens_by_the_turn_of_one_step(rate: int, share: float, maximal: int) -> None:
    # Beside it stand terms of second order: .3 % at 1/240 s, and a part of that by the step.
    assert astray(rate, maximal) == pytest.approx(widening(rate), rel=share)
