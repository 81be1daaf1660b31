"""DART warns of a body without inertia, lets it fall and passes over a torque, in dartpy's own words."""

import numpy as np
import pytest

from tests.vendor.dart_world import G, dartpy, make_world

pytestmark = pytest.mark.dart


def test_a_free_body_without_inertia_falls_and_is_turned_by_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """It falls by g t, while a torque, which nothing could answer, turns it by nothing and raises nothing."""
    world, skeleton = make_world("ode", 1e-3), dartpy.dynamics.Skeleton("point")
    _, node = skeleton.createFreeJointAndBodyNodePair()
    node.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.zeros((3, 3))))
    world.addSkeleton(skeleton)
    for _ in range(100):
        node.addExtTorque(np.array([1.0, 0.0, 0.0]))
        world.step()
    assert float(node.getCOMLinearVelocity()[2]) == pytest.approx(-0.1 * G, abs=1e-9)
    assert np.array_equal(node.getAngularVelocity(), np.zeros(3))
    assert "Value should be positive" in "".join(capfd.readouterr())
