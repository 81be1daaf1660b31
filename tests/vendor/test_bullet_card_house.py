"""Two houses of two cards in pybullet's own words: one with more friction at its feet than it needs, one with less."""

import math

import pytest

from tests.vendor.bullet_world import World, pybullet

pytestmark = pytest.mark.bullet

DT, ANGLE = 1 / 240, math.radians(20.0)
HALF = (0.01, 0.15, 0.2)
"""Half extents of a card [m]."""
CRITICAL = (math.tan(ANGLE) - HALF[0] / HALF[2]) / 2
"""The least friction at the feet with which a house stands."""


def height(world: World, friction: float) -> float:
    """The height of the lower of two cards after 2 s, over that at the start. Bullet multiplies the frictions of two bodies."""
    world.setPhysicsEngineParameter(fixedTimeStep=DT, numSolverIterations=200, solverResidualThreshold=0.0)
    world.setGravity(0.0, 0.0, -9.81)
    across = HALF[2] * math.sin(ANGLE) + HALF[0] * math.cos(ANGLE)
    high = HALF[2] * math.cos(ANGLE) + HALF[0] * math.sin(ANGLE)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[2.0, 2.0, 0.05])
    world.changeDynamics(world.createMultiBody(0.0, slab, basePosition=(0.0, 0.0, -0.05)), -1, lateralFriction=friction)
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=HALF)
    cards = []
    for way in (1, -1):
        turn = (0.0, math.sin(way * ANGLE / 2), 0.0, math.cos(ANGLE / 2))
        card = world.createMultiBody(0.1, shape, basePosition=(-way * across, 0.0, high), baseOrientation=turn)
        world.changeDynamics(card, -1, lateralFriction=1.0, linearDamping=0.0, angularDamping=0.0)
        cards.append(card)
    for _ in range(round(2 / DT)):
        world.stepSimulation()
    return min(float(world.getBasePositionAndOrientation(card)[0][2]) for card in cards) / high


@pytest.mark.parametrize(("margin", "stands"), [(0.5, True), (0.1, True), (-0.1, False), (-0.5, False)])
def test_a_house_stands_with_more_friction_than_it_needs_and_falls_with_less(world: World, margin: float, stands: bool) -> None:
    # A card that lies down has its centre at its half thickness, 0.05 of its height when it stands.
    left = height(world, (1 + margin) * CRITICAL)
    assert left > 0.9 if stands else left < 0.2
