"""Boxes at rest under steps of uneven lengths, in pybullet's own words."""

import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet


def stir(steps: tuple[float, ...], coordinates: int, iterations: int = 200) -> float:
    """RMS speed [m/s], in the sixth second, of a box and a column of five. Args: steps: in turns, in 1/240 s."""
    with World() as world:
        world.setPhysicsEngineParameter(numSolverIterations=iterations, solverResidualThreshold=1e-9)
        world.setGravity(0, 0, -9.81)
        ground = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[50, 50, 50])
        world.body(ground, 0.0, (0, 0, -50), coordinates, lateralFriction=0.7)
        cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1] * 3)
        places = [(-1.0, 0.0, 0.1), *((0.0, 0.0, 0.1 * (2 * k + 1)) for k in range(5))]
        bodies = [world.body(cube, 1.0, place, coordinates, lateralFriction=0.7) for place in places]
        squares = []
        for k in range(1440):
            world.setTimeStep(steps[k % len(steps)] / 240)
            world.stepSimulation()
            if k >= 1200:
                squares.append(sum(v * v for body in bodies for v in world.getBaseVelocity(body)[0]) / len(bodies))
        return float(sum(squares) / len(squares)) ** 0.5


@pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_steps_of_uneven_lengths_stir_boxes_at_rest_five_times_as_much_as_even_ones_as_long_as_the_longest(
    coordinates: int,
) -> None:
    """By a tenth of a millimetre a second: a quarter of what 0.01 g gives in a step."""
    uneven = stir((0.8, 1.2), coordinates)
    assert 5e-5 < uneven < 4e-4
    assert uneven > 3 * stir((1.0,), coordinates)
    assert uneven > 3 * stir((1.2,), coordinates)


def test_five_times_the_iterations_do_not_halve_it() -> None:
    assert stir((0.8, 1.2), MULTIBODY, 1000) > stir((0.8, 1.2), MULTIBODY) / 2
