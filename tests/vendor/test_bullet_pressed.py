"""A cube pressed against a wall far beyond its weight, in pybullet's own words: a gap at the start decides its fate."""

import pytest

from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

DT, G, HALF = 1 / 240, 9.81, 0.1


def place(world: World, push: float, gap: float) -> tuple[float, float]:
    """How far [m] the cube is in the wall, and how far it has sunk, 1 s after it was let go `gap` before the wall."""
    world.setPhysicsEngineParameter(fixedTimeStep=DT, numSolverIterations=200, solverResidualThreshold=0.0)
    world.setGravity(push * G, 0.0, -G)
    wall = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF, 3.0, 6.0])
    world.body(wall, 0.0, (HALF, 0.0, 0.0), MULTIBODY, lateralFriction=1.0)
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
    cube = world.body(shape, 1.0, (-HALF - gap, 0.0, 0.0), MULTIBODY, lateralFriction=0.8)
    for _ in range(240):
        world.stepSimulation()
    x, _, z = world.getBasePositionAndOrientation(cube)[0]
    return float(x) + HALF, -float(z)


def test_a_cube_that_touches_the_wall_is_held_under_twenty_thousand_weights(world: World) -> None:
    deep, sunk = place(world, 2e4, 0.0)
    # Free fall for a step, twice at most, is 2 g dt^2 = 0.34 mm; Bullet's contact slop and bias add 0.01 mm.
    assert abs(deep) < 1e-3
    assert sunk < 1e-3


def test_a_gap_of_a_tenth_of_a_micrometre_sends_it_through(world: World) -> None:
    # A free step under the push is p g dt^2 = 3.4 m, whatever the width of the gap.
    assert place(world, 2e4, 1e-7)[0] > 1.0
