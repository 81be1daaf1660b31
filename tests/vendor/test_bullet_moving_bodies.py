"""What friction makes of a plate whose velocity is set before each step in pybullet: without mass, and heavy."""

import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

SPEED, STEPS, DT, HEAVY = 0.5, 500, 1e-3, 1e12
GONE = SPEED * STEPS * DT


def carried(world: World, mass: float, coordinates: int) -> tuple[float, float]:
    """How far [m] a plate at .5 m/s takes a box of friction 1 in half a second, and how far it goes itself."""
    world.setGravity(0.0, 0.0, -9.81)
    world.setPhysicsEngineParameter(fixedTimeStep=DT)
    boxes = [world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half) for half in ([2.0, 1.0, 0.1], [0.2, 0.2, 0.05])]
    plate, box = (
        world.createMultiBody(m, shape, basePosition=[0.0, 0.0, z], useMaximalCoordinates=coordinates)
        for m, shape, z in zip((mass, 1.0), boxes, (-0.1, 0.05), strict=True)
    )
    for number in (plate, box):
        world.changeDynamics(number, -1, lateralFriction=1.0)
        world.release(number, coordinates)
    for _ in range(STEPS):
        world.resetBaseVelocity(plate, [SPEED, 0.0, 0.0], [0.0] * 3)
        position = world.getBasePositionAndOrientation(plate)[0]
        world.applyExternalForce(plate, -1, [0.0, 0.0, 9.81 * mass], position, pybullet.WORLD_FRAME)
        world.stepSimulation()
    return tuple(world.getBasePositionAndOrientation(number)[0][0] for number in (box, plate))


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL])
def test_a_heavy_plate_takes_along_what_lies_on_it(world: World, coordinates: int) -> None:
    """Friction of 1 stops the slip in v / g, on v^2 / 2 g; it begins one step late."""
    box, plate = carried(world, HEAVY, coordinates)
    assert plate == pytest.approx(GONE, abs=1e-9)
    assert box == pytest.approx(GONE - SPEED**2 / (2 * 9.81), abs=2 * SPEED * DT)


def test_a_plate_without_mass_does_so_as_a_multibody_and_stands_still_in_maximal_coordinates(world: World) -> None:
    """So a mass of 0 would do where all bodies are multibodies; in maximal coordinates it is static all the same."""
    box, plate = carried(world, 0.0, MULTIBODY)
    assert plate == pytest.approx(GONE, abs=1e-9)
    assert box == pytest.approx(GONE - SPEED**2 / (2 * 9.81), abs=2 * SPEED * DT)
    world.resetSimulation()
    box, plate = carried(world, 0.0, MAXIMAL)
    assert plate == 0.0
    assert abs(box) < 1e-5
