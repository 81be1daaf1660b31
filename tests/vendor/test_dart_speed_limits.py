"""DART's velocity limits, in dartpy's own words: a constraint of the joint, once limits are enforced."""

from typing import Any

import numpy as np
import pytest

from tests.vendor.dart_world import dartpy, make_world

pytestmark = pytest.mark.dart

LIMIT, DT = 2.0, 1e-3


def _limited(joint: Any, enforced: bool) -> None:
    joint.setAxis(np.array([0.0, 1.0, 0.0]))
    joint.setLimitEnforcement(enforced)
    joint.setVelocityLowerLimit(0, -LIMIT)
    joint.setVelocityUpperLimit(0, LIMIT)


def _inertia(node: Any, moment: float) -> None:
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), moment * np.eye(3)))


@pytest.mark.parametrize(("enforced", "rate"), [(False, 6.0), (True, LIMIT)])
def test_a_hinge_under_a_constant_torque_stays_at_its_limit_where_limits_are_enforced(enforced: bool, rate: float) -> None:
    """3 N m on .5 kg m2 for a second: 6 rad/s, or the limit, reached after LIMIT / 6 s."""
    world, skeleton = make_world("ode", DT), dartpy.dynamics.Skeleton("arm")
    joint, node = skeleton.createRevoluteJointAndBodyNodePair()
    _limited(joint, enforced)
    _inertia(node, 0.5)
    world.setGravity((0.0, 0.0, 0.0))
    world.addSkeleton(skeleton)
    for _ in range(1000):
        joint.setForce(0, 3.0)
        world.step()
    assert joint.getVelocity(0) == pytest.approx(rate, abs=1e-6)
    way = LIMIT - LIMIT**2 / 12 if enforced else 3.0
    assert joint.getPosition(0) == pytest.approx(way, abs=2 * LIMIT * DT)


def test_the_limit_reacts_on_the_other_body() -> None:
    """A base and a link in space, .7 and .5 kg m2: their angular momenta cancel at the limit as before it."""
    world, skeleton = make_world("ode", DT), dartpy.dynamics.Skeleton("pair")
    _, base = skeleton.createFreeJointAndBodyNodePair()
    joint, node = skeleton.createRevoluteJointAndBodyNodePair(base)
    _limited(joint, True)
    _inertia(base, 0.7)
    _inertia(node, 0.5)
    world.setGravity((0.0, 0.0, 0.0))
    world.addSkeleton(skeleton)
    for _ in range(1000):
        joint.setForce(0, 1.0)
        world.step()
    assert joint.getVelocity(0) == pytest.approx(LIMIT, abs=1e-6)
    assert 0.7 * base.getAngularVelocity()[1] + 0.5 * node.getAngularVelocity()[1] == pytest.approx(0.0, abs=1e-9)
