"""Two cubes that start inside each other, in pybullet's own words: with what speed are they thrown apart?"""

import math

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

G, HALF = 9.81, 0.1
FRICTION = math.sqrt(0.5)
"""Of each body: Bullet multiplies those of two."""


def thrown(overlap: float, dt: float, ground: str = "box") -> float:
    """The speed [m/s] whose throw would lift the upper cube as high over its place as it gets, as pybullet comes."""
    with World() as world:
        world.setGravity(0, 0, -G)
        world.setTimeStep(dt)
        if ground == "plane":
            world.createMultiBody(0, world.createCollisionShape(pybullet.GEOM_PLANE))
        else:
            slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[10, 10, 1])
            world.createMultiBody(0, slab, basePosition=[0, 0, -1])
        cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
        lower = world.createMultiBody(1, cube, basePosition=[0, 0, HALF])
        upper = world.createMultiBody(1, cube, basePosition=[0, 0, HALF * (3 - 2 * overlap)])
        for body in (0, lower, upper):
            world.changeDynamics(body, -1, lateralFriction=FRICTION)
        highest = 0.0
        for _ in range(round(1 / dt)):
            world.stepSimulation()
            highest = max(highest, world.getBasePositionAndOrientation(upper)[0][2])
    return math.sqrt(2 * G * max(0.0, highest - 3 * HALF))


def test_a_box_as_ground_throws_them_a_little_harder_than_a_plane() -> None:
    """To both sides of the metre a second at which the limit is drawn."""
    assert 0.9 < thrown(0.45, 1 / 240, "plane") < 1.0 < thrown(0.45, 1 / 240) < 1.2


def test_a_share_of_a_depth_is_taken_back_in_each_step_so_that_smaller_steps_throw_harder() -> None:
    assert thrown(0.225, 1 / 240) == 0.0
    assert thrown(0.225, 1 / 960) > 1.0
