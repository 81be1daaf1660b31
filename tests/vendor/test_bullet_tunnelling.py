"""Which balls get through a thin wall, in pybullet's own words."""

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

SPEED, BALLS = 50.0, 64


@pytest.mark.parametrize(("coordinates", "swept", "passed"), [(MULTIBODY, 0.0, 43), (MAXIMAL, 0.0, 43), (MAXIMAL, 0.04, 0)])
def test_balls_pass_a_wall_of_a_centimetre_at_50_m_per_s_unless_they_are_swept(
    world: World, coordinates: int, swept: float, passed: int
) -> None:
    """Balls of 5 cm, each at another phase of its step of 21 cm; continuous collision is off by default."""
    wall = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.005, BALLS / 2 + 1, 0.5])
    world.createMultiBody(0.0, wall, basePosition=[0.005, (BALLS - 1) / 2, 0.0], useMaximalCoordinates=coordinates)
    shape, balls = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.05), []
    ways = 0.05 + np.random.default_rng(0).uniform(0.0, SPEED / 60, BALLS)
    for k, way in enumerate(ways.tolist()):
        ball = world.createMultiBody(1.0, shape, basePosition=[-way - 0.05, k, 0.0], useMaximalCoordinates=coordinates)
        if swept:
            world.changeDynamics(ball, -1, ccdSweptSphereRadius=swept)
        world.resetBaseVelocity(ball, [SPEED, 0.0, 0.0])
        balls.append(ball)
    for _ in range(60):
        world.stepSimulation()
    ends = np.array([world.getBasePositionAndOrientation(ball)[0][0] for ball in balls])
    # The centre beyond the wall's middle, or the front deeper than it: here the same balls.
    assert int((ends > 0.005).sum()) == int((ends + 0.05 > 0.005).sum()) == passed
