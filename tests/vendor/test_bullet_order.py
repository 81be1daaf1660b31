"""Bullet's integrator is of the first order, in pybullet's own words: an error shrinks with the step, and as fast as it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, LENGTH, START = 9.81, 1.0, 1.0


def flight(dt: float, maximal: int) -> float:
    """By how much [m] a body that falls for a second is off."""
    with World() as world:
        world.setGravity(0.0, 0.0, -G)
        world.setPhysicsEngineParameter(fixedTimeStep=dt)
        body = world.body(-1, 1.0, (0, 0, 0), maximal)
        for _ in range(round(1 / dt)):
            world.stepSimulation()
        return float(world.getBasePositionAndOrientation(body)[0][2]) + G / 2


def pendulum(dt: float) -> float:
    """By how much [rad] a point at the end of a rod is off after a second, let go at 1 rad."""
    with World() as world:
        world.setGravity(0.0, 0.0, -G)
        world.setPhysicsEngineParameter(fixedTimeStep=dt)
        body = world.createMultiBody(
            0.0,
            linkMasses=[1.0],
            linkCollisionShapeIndices=[-1],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0, 0, 0]],
            linkOrientations=[[0, 0, 0, 1]],
            linkInertialFramePositions=[[0, 0, -LENGTH]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_REVOLUTE],
            linkJointAxis=[[0, 1, 0]],
        )
        world.release(body, MULTIBODY)
        world.changeDynamics(body, 0, localInertiaDiagonal=[1e-9] * 3, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0)
        world.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, targetVelocity=0.0, force=0.0)
        world.resetJointState(body, 0, START)
        for _ in range(round(1 / dt)):
            world.stepSimulation()
        truth = solve_ivp(lambda _, y: (y[1], -G / LENGTH * math.sin(y[0])), (0, 1), (START, 0.0), rtol=1e-11, atol=1e-12)
        return float(world.getJointState(body, 0)[0] - truth.y[0, -1])


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL])
@pytest.mark.parametrize("rate", [240, 960, 7680])
def test_a_fall_is_off_by_g_dt_t_over_2(rate: int, maximal: int) -> None:
    """Of semi-implicit Euler, exactly; a share of 1e-9 is what rounding adds up to in 7680 steps."""
    assert flight(1 / rate, maximal) == pytest.approx(-G / rate / 2, rel=1e-9, abs=1e-9)


def test_a_pendulum_converges_in_first_order() -> None:
    errors = np.abs([pendulum(1 / rate) for rate in (240, 480, 960, 1920)])
    # An error a dt + b dt^2 halves but for b dt/a, which is of the order of a step's phase, dt sqrt(g/l), a hundredth.
    assert errors[:-1] / errors[1:] == pytest.approx(2.0, rel=0.03)
