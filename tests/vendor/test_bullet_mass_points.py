"""pybullet turns no body without inertia, however it is twisted, in its own words."""

import pytest

from tests.vendor.bullet_world import MAXIMAL, World

pytestmark = pytest.mark.bullet


def test_a_moment_of_nothing_is_an_endless_one(world: World) -> None:
    """Its inverse is taken to be 0: an endless one, and no point."""
    body = world.createMultiBody(1.0, -1, useMaximalCoordinates=MAXIMAL)
    world.changeDynamics(body, -1, mass=1.0, localInertiaDiagonal=[0.0] * 3)
    world.applyExternalTorque(body, -1, [1.0, 0.0, 0.0], 1)
    world.stepSimulation()
    assert world.getBaseVelocity(body)[1] == (0.0, 0.0, 0.0)
