"""A free plate that spins fast in DART, in dartpy's own words: its only integrator is semi-implicit Euler."""

import math

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.dart_world import dartpy, make_world

pytestmark = pytest.mark.dart


def spin(speed: float, dt: float) -> float:
    """The greatest error of the plate's angular momentum within 2 s, as a share of it; infinite beyond a thousand."""
    world = make_world("fcl", dt)
    world.setGravity((0.0, 0.0, 0.0))
    skeleton = dartpy.dynamics.Skeleton("plate")
    joint, node = skeleton.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(spinning.PLATE, np.zeros(3), np.diag(spinning.MOMENTS)))
    joint.setAngularVelocity(speed * spinning.UNIT)
    world.addSkeleton(skeleton)
    off = 0.0
    for _ in range(round(2 / dt)):
        world.step()
        off = max(off, spinning.momentum_off(node.getTransform().rotation(), node.getAngularVelocity(), speed))
        # Left at once: what comes next is not finite, and DART repairs it aloud.
        if not off < 1e3:
            return math.inf
    return off


def test_a_tenth_of_a_radian_a_step_gains_without_bound() -> None:
    """The gyroscopic torque is that of the step's start."""
    assert spin(100.0, 1 / 960) == math.inf


def test_a_fortieth_of_a_radian_a_step_errs_by_half() -> None:
    assert spin(100.0, 1 / 3840) == pytest.approx(0.43, abs=0.01)


def test_ten_rad_per_s_are_kept_to_a_twentieth_at_1_240_s() -> None:
    assert spin(10.0, 1 / 240) < 0.05
