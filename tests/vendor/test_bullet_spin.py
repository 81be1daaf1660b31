"""A free plate that spins fast in Bullet, in both coordinates and with sub-steps, in pybullet's own words."""

import numpy as np
import pytest

from tests.vendor import spinning
from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet


def spin(world: World, speed: float, dt: float, coordinates: int, damped: bool = False, substeps: int = 1) -> float:
    """The greatest error of the plate's angular momentum within 2 s, as a share of it."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSubSteps=substeps if substeps > 1 else 0)
    shape = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.01)
    plate = world.createMultiBody(spinning.PLATE, shape, useMaximalCoordinates=coordinates)
    world.changeDynamics(plate, -1, mass=spinning.PLATE, localInertiaDiagonal=spinning.MOMENTS.tolist())
    if not damped:
        world.release(plate, coordinates)
    # In maximal coordinates the first step has the inertia of the shape: it is taken at rest.
    world.stepSimulation()
    world.resetBaseVelocity(plate, [0, 0, 0], (speed * spinning.UNIT).tolist())
    off = 0.0
    for _ in range(round(2 / dt)):
        world.stepSimulation()
        R = np.array(world.getMatrixFromQuaternion(world.getBasePositionAndOrientation(plate)[1])).reshape(3, 3)
        off = max(off, spinning.momentum_off(R, np.array(world.getBaseVelocity(plate)[1]), speed))
    return off


@pytest.mark.parametrize(("damped", "kept"), [(True, False), (False, True)])
def test_as_it_comes_a_plate_at_10_rad_per_s_loses_half_of_its_spin_and_without_damping_a_twentieth(
    world: World, damped: bool, kept: bool
) -> None:
    assert (spin(world, 10.0, 1 / 240, MULTIBODY, damped) < 0.1) is kept


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_tenth_of_a_radian_a_step_loses_a_tenth_of_the_angular_momentum_and_more(world: World, substeps: int) -> None:
    """Maximal coordinates have an implicit gyroscopic torque, which is stable and turns the momentum; at 100 rad/s four
    sub-steps of 1/960 s leave half of that."""
    off = spin(world, 100.0, 1 / 960, MAXIMAL, substeps=substeps)
    assert 0.1 < off < 1.0


def test_multibody_coordinates_gain_without_bound_at_a_tenth_of_a_radian_a_step(world: World) -> None:
    assert spin(world, 100.0, 1 / 960, MULTIBODY) > 1e3
