"""How many iterations a heavy box on a light one takes, in pybullet's own words: a number for each unit of the mass ratio."""

import pytest

from tests.vendor.bullet_world import MAXIMAL, World, pybullet

pytestmark = pytest.mark.bullet

G, HALF = 9.81, 0.1


def sag(ratio: float, iterations: int, dt: float = 1 / 240) -> float:
    """How far [m] the upper of two cubes, `ratio` times as heavy as the lower, is down or up within 2 s, at most."""
    with World() as world:
        world.setPhysicsEngineParameter(fixedTimeStep=dt)
        world.setPhysicsEngineParameter(numSolverIterations=iterations, solverResidualThreshold=1e-9, warmStartingFactor=0.85)
        world.setGravity(0.0, 0.0, -G)
        slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[10.0] * 3)
        world.body(slab, 0.0, (0.0, 0.0, -10.0), MAXIMAL, lateralFriction=1.0)
        cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
        _, heavy = (
            world.body(cube, mass, (0.0, 0.0, height), MAXIMAL, lateralFriction=0.5)
            for mass, height in ((1.0, HALF), (ratio, 3 * HALF))
        )
        off = 0.0
        for _ in range(round(2 / dt)):
            world.stepSimulation()
            off = max(off, abs(float(world.getBasePositionAndOrientation(heavy)[0][2]) - 3 * HALF))
        return off


@pytest.mark.parametrize("ratio", [500, 1000, 2000])
def test_six_tenths_of_the_mass_ratio_hold_the_stack_alike_at_any_ratio(ratio: int) -> None:
    # A step of free fall twice, and a millimetre for each contact, are 2.3 mm; a quarter of it is what the contacts give.
    assert sag(ratio, round(0.6 * ratio)) == pytest.approx(sag(800, 480), rel=0.02)
    assert sag(ratio, round(0.6 * ratio)) < 2.3e-3 / 4


def test_two_hundred_iterations_do_not_hold_a_thousand_on_one() -> None:
    assert sag(1000, 200) > 2.3e-3


@pytest.mark.parametrize(("ratio", "fails", "holds"), [(300, 200, 1000), (1000, 200, 10_000)])
def test_at_a_thirtieth_of_a_second_iterations_decide_how_heavy_the_upper_may_be(ratio: int, fails: int, holds: int) -> None:
    """It has fallen where it is down by the lower one's half height, and holds within a step of free fall, twice."""
    assert sag(ratio, fails, 1 / 30) > HALF
    assert sag(ratio, holds, 1 / 30) < 2 * G / 30**2
