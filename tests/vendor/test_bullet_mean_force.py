"""A heavy box dropped on two small ones: the ground bears the weight in the mean over all steps, in pybullet's own words.

Each fourth step alone, as often as a film has pictures, tells another mean, since forces shake from step to step.
"""

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

DT, G = 1 / 240, 9.81
SMALL, APART, LARGE, DROP = 0.1, 0.4, (0.5, 0.25, 0.25), 0.02
SETTLED, DURATION = 1.0, 2.0
ALLOWED = DT / (DURATION - SETTLED)
"""The change of momentum by one step of gravity, over the weight for the time of the mean."""


def borne(world: World, coordinates: int) -> np.ndarray:
    """What the ground bears in each step after SETTLED, over the weight."""
    world.setPhysicsEngineParameter(fixedTimeStep=DT, numSolverIterations=200, solverResidualThreshold=0.0)
    world.setPhysicsEngineParameter(warmStartingFactor=0.85)
    world.setGravity(0, 0, -G)
    ground = world.body(world.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), coordinates, lateralFriction=0.5)
    cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[SMALL] * 3)
    for x in (-APART, APART):
        world.body(cube, 1.0, (x, 0, SMALL), coordinates, lateralFriction=0.5)
    box = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=LARGE)
    heavy = world.body(box, 400.0, (0, 0, 2 * SMALL + LARGE[2] + DROP), coordinates, lateralFriction=0.5)
    x, y, z = (400.0 / 3 * half**2 for half in LARGE)
    world.changeDynamics(heavy, -1, localInertiaDiagonal=[y + z, x + z, x + y])
    forces = []
    for _ in range(round(DURATION / DT)):
        world.stepSimulation()
        # Signs aside: all that the plane does points up.
        forces.append(sum(abs(point[9]) for point in world.getContactPoints(bodyA=ground)))
    return np.array(forces[round(SETTLED / DT) :]) / (402.0 * G)


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_the_ground_bears_the_weight_in_the_mean_over_all_steps(world: World, coordinates: int) -> None:
    forces = borne(world, coordinates)
    off = abs(forces.mean() - 1.0)
    assert off <= ALLOWED
    assert max(abs(forces[k::4].mean() - 1.0) for k in range(4)) > 2 * off
