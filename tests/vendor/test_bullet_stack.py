"""Towers of boxes at coarse steps, with and without Bullet's own sub-steps, and at fine ones, in pybullet's own words."""

import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

COARSE = 1 / 15
HALF = 0.1
"""Half the edge [m] of the cubes, which weigh 1 kg each."""
BOTH = pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])


def heights(world: World, boxes: int, coordinates: int, substeps: int, iterations: int = 200) -> tuple[float, float]:
    """The least and the greatest height of the top of cubes built exactly touching, within 5 s of 1/15 s, over its start."""
    world.setPhysicsEngineParameter(fixedTimeStep=COARSE, numSubSteps=substeps if substeps > 1 else 0)
    world.setPhysicsEngineParameter(numSolverIterations=iterations, solverResidualThreshold=0.0)
    world.setGravity(0, 0, -9.81)
    plane = world.createCollisionShape(pybullet.GEOM_PLANE)
    world.body(plane, 0.0, (0, 0, 0), coordinates, lateralFriction=1.0)
    cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
    tower = [world.body(cube, 1.0, (0, 0, HALF * (2 * k + 1)), coordinates, lateralFriction=0.5) for k in range(boxes)]
    found = [HALF * (2 * boxes - 1)]
    for _ in range(round(5 / COARSE)):
        world.stepSimulation()
        found.append(float(world.getBasePositionAndOrientation(tower[-1])[0][2]))
    return min(found) / found[0], max(found) / found[0]


@BOTH
@pytest.mark.parametrize("iterations", [50, 200])
def test_a_single_box_sinks_through_a_plane_at_1_15_s(world: World, coordinates: int, iterations: int) -> None:
    # g dt^2 = 44 mm a step: what is found that deep, and deeper after each wrong answer, ends below the ground.
    assert heights(world, 1, coordinates, 1, iterations)[0] < 0.5


@BOTH
@pytest.mark.parametrize("boxes", [1, 4, 8])
def test_two_sub_steps_hold_a_tower_of_eight(world: World, coordinates: int, boxes: int) -> None:
    # Each support shows a step after the one below it, k (k + 1)/2 g h^2 for box k at h = 1/30 s, over its height: .49 for
    # eight, of which Bullet shows a tenth.
    assert heights(world, boxes, coordinates, 2) == pytest.approx((1.0, 1.0), abs=0.1)


@BOTH
@pytest.mark.parametrize("boxes", [1, 4, 8])
def test_four_sub_steps_hold_it_four_times_as_well(world: World, coordinates: int, boxes: int) -> None:
    assert heights(world, boxes, coordinates, 4) == pytest.approx((1.0, 1.0), abs=0.1 / 4)


@pytest.mark.parametrize(
    "coordinates", [pytest.param(MULTIBODY, id="multibody", marks=pytest.mark.slow), pytest.param(MAXIMAL, id="maximal")]
)
def test_the_vendors_step_holds_sixteen(world: World, coordinates: int) -> None:
    # 16 sub-steps of a 15th are the 1/240 s that a new world starts with: two hundredths of the bound above.
    assert heights(world, 16, coordinates, 16) == pytest.approx((1.0, 1.0), abs=0.1 / 64)


def test_a_new_world_steps_by_a_240th_without_sub_steps(world: World) -> None:
    said = world.getPhysicsEngineParameters()
    assert said["fixedTimeStep"] == pytest.approx(1 / 240, rel=1e-12)
    assert said["numSubSteps"] == 0


def sag(world: World, rate: int, coordinates: int, slop: float) -> tuple[float, float]:
    """How far [m] the top of ten cubes built exactly touching comes down within 30 ms at steps of 1/rate s, and stays down."""
    world.setPhysicsEngineParameter(fixedTimeStep=1 / rate, numSolverIterations=200, solverResidualThreshold=0.0)
    world.setPhysicsEngineParameter(contactSlop=slop, warmStartingFactor=0.85)
    world.setGravity(0, 0, -9.81)
    world.body(world.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), coordinates, lateralFriction=1.0)
    cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
    tower = [world.body(cube, 1.0, (0, 0, HALF * (2 * k + 1)), coordinates, lateralFriction=0.5) for k in range(10)]
    sunk = []
    for _ in range(round(0.03 * rate)):
        world.stepSimulation()
        sunk.append(19 * HALF - float(world.getBasePositionAndOrientation(tower[-1])[0][2]))
    return max(sunk), sunk[-1]


@BOTH
@pytest.mark.parametrize("rate", [1920, *(pytest.param(rate, marks=pytest.mark.slow) for rate in (3840, 7680))])
def test_at_fine_steps_a_tower_stands_as_deep_as_ten_contact_slops(world: World, coordinates: int, rate: int) -> None:
    # Ten contacts of 1e-5 m, that of a new world; beside it a step's fall in some of them, g dt^2 = 2.7e-6 m at 1/1920 s.
    most, last = sag(world, rate, coordinates, 1e-5)
    assert last == pytest.approx(1e-4, rel=0.1)
    assert most < 1.1e-4


@BOTH
@pytest.mark.parametrize("rate", [1920, *(pytest.param(rate, marks=pytest.mark.slow) for rate in (3840, 7680))])
def test_without_a_slop_it_comes_down_by_the_steps_until_all_supports_show(world: World, coordinates: int, rate: int) -> None:
    # Each support shows a step after the one below it; whether two that touch exactly overlap is a matter of rounding.
    most, last = sag(world, rate, coordinates, 0.0)
    falls = [9.81 / rate**2 * steps * (steps + 1) / 2 for steps in range(1, 11)]
    assert any(most == pytest.approx(fall, rel=1e-6) for fall in falls)
    assert last < most / 4
