"""DART's integrator is of the first order, in dartpy's own words: an error shrinks with the step, and as fast as it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.vendor.dart_world import UP, G, dartpy, make_pose, make_world

pytestmark = pytest.mark.dart

LENGTH, START = 1.0, 1.0


def flight(dt: float) -> float:
    """By how much [m] a body that falls for a second is off."""
    world = make_world("fcl", dt)
    skeleton = dartpy.dynamics.Skeleton("ball")
    _, node = skeleton.createFreeJointAndBodyNodePair()
    world.addSkeleton(skeleton)
    for _ in range(round(1 / dt)):
        world.step()
    return float(node.getWorldTransform().translation()[2]) + G / 2


def pendulum(dt: float) -> float:
    """By how much [rad] a point at the end of a rod is off after a second, let go at 1 rad."""
    world = make_world("fcl", dt)
    skeleton = dartpy.dynamics.Skeleton("pendulum")
    joint, node = skeleton.createRevoluteJointAndBodyNodePair()
    joint.setAxis(np.array([0.0, 1.0, 0.0]))
    joint.setTransformFromChildBodyNode(make_pose(UP, LENGTH))
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), 1e-9 * np.eye(3)))
    joint.setPosition(0, START)
    world.addSkeleton(skeleton)
    for _ in range(round(1 / dt)):
        world.step()
    truth = solve_ivp(lambda _, y: (y[1], -G / LENGTH * math.sin(y[0])), (0, 1), (START, 0.0), rtol=1e-11, atol=1e-12)
    return float(joint.getPosition(0) - truth.y[0, -1])


@pytest.mark.parametrize("rate", [240, 960, 7680])
def test_a_fall_is_off_by_g_dt_t_over_2(rate: int) -> None:
    """Of semi-implicit Euler, exactly; a share of 1e-9 is what rounding adds up to in 7680 steps."""
    assert flight(1 / rate) == pytest.approx(-G / rate / 2, rel=1e-9, abs=1e-9)


def test_a_pendulum_converges_in_first_order() -> None:
    errors = np.abs([pendulum(1 / rate) for rate in (240, 480, 960, 1920)])
    # An error a dt + b dt^2 halves but for b dt/a, which is of the order of a step's phase, dt sqrt(g/l), a hundredth.
    assert errors[:-1] / errors[1:] == pytest.approx(2.0, rel=0.03)
