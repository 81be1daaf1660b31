"""When Bullet's solver stops early, and what is then left to move, in pybullet's own words.

The threshold `solverResidualThreshold` is held against the square of the greatest change of speed in an iteration: 1e-7, that
of a new world, is 3e-4 m/s, and 1e-9 is 3e-5.
"""

import math

import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, HALF, STEPS = 9.81, 0.1, 480
BOTH = pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])


def held(coordinates: int, threshold: float) -> tuple[float, float]:
    """Iterations a step, and speed in the last second [m/s], of a cube at nine tenths of its friction on a slope."""
    with World() as world:
        world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=threshold, warmStartingFactor=0.85)
        world.setPhysicsEngineParameter(reportSolverAnalytics=1)
        slope = math.atan(0.45)
        world.setGravity(G * math.sin(slope), 0.0, -G * math.cos(slope))
        slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[10.0] * 3)
        world.body(slab, 0.0, (0.0, 0.0, -10.0), coordinates, lateralFriction=1.0)
        cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
        body = world.body(cube, 1.0, (0.0, 0.0, HALF), coordinates, lateralFriction=0.5)
        iterations, places = 0, []
        for _ in range(STEPS):
            iterations += sum(island["numIterationsUsed"] for island in world.stepSimulation())
            places.append(float(world.getBasePositionAndOrientation(body)[0][0]))
        return iterations / STEPS, abs(places[-1] - places[STEPS // 2 - 1]) / (STEPS / 2 / 240)


@BOTH
def test_without_a_threshold_a_cube_on_a_slope_takes_all_iterations_and_with_one_a_tenth(coordinates: int) -> None:
    used = {threshold: held(coordinates, threshold)[0] for threshold in (0.0, 1e-9, 1e-7)}
    assert used[0.0] > 150
    # A solver that converges by a share a sweep takes as many sweeps for each power of ten.
    assert used[1e-7] < used[1e-9] < 25


@BOTH
def test_it_creeps_by_less_than_the_root_of_the_threshold(
    coordinates: int,
) -> None:
    creep = {threshold: held(coordinates, threshold)[1] for threshold in (1e-9, 1e-7)}
    assert 1e-5 < creep[1e-7] < math.sqrt(1e-7)
    assert creep[1e-9] < 1e-5


def rest(threshold: float) -> float:
    """The greatest speed [m/s] in the last second of five of a stack of four cubes in maximal coordinates, on a box."""
    with World() as world:
        world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=threshold, warmStartingFactor=0.85)
        world.setGravity(0.0, 0.0, -G)
        slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[10.0] * 3)
        world.body(slab, 0.0, (0.0, 0.0, -10.0), MAXIMAL, lateralFriction=1.0)
        cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
        stack = [world.body(cube, 1.0, (0.0, 0.0, HALF * (2 * k + 1)), MAXIMAL, lateralFriction=0.5) for k in range(4)]
        speeds = []
        for step in range(5 * 240):
            world.stepSimulation()
            if step >= 4 * 240:
                speeds += [math.hypot(*world.getBaseVelocity(body)[0]) for body in stack]
        return max(speeds)


def test_a_stack_trembles_under_the_vendors_threshold_and_rests_under_1e_9() -> None:
    # No more than an iteration may still change, 3.2e-5 and 3.2e-4 m/s.
    assert rest(1e-9) < math.sqrt(1e-9) < 1e-4 < rest(1e-7) < math.sqrt(1e-7)
