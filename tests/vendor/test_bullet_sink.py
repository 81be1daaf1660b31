"""How deep Bullet lets a box sink that is set down, and what it reports of that, told in pybullet's own words.

The depth of a point of contact is that of the pose before the step, so that a reported depth is no measure of where bodies are.
"""

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, HALF = 9.81, 0.1
CORNERS = HALF * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def depths(world: World, maximal: int, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of a cube set down on a plane, after each step: its lowest corner's and its centre's sink, and the depth reported [m]."""
    world.setPhysicsEngineParameter(fixedTimeStep=1 / 240)
    world.setGravity(0, 0, -G)
    world.body(world.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), maximal)
    cube = world.body(world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3), 1.0, (0, 0, HALF), maximal)
    corner, centre, reported = [], [], []
    for _ in range(steps):
        world.stepSimulation()
        place, turn = world.getBasePositionAndOrientation(cube)
        turned = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3)
        corner.append(-float((CORNERS @ turned.T + place)[:, 2].min()))
        centre.append(HALF - place[2])
        reported.append(max([0.0, *(-point[8] for point in world.getContactPoints())]))
    return np.array(corner), np.array(centre), np.array(reported)


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_the_depth_that_is_reported_is_that_of_the_pose_before_the_step(world: World, maximal: int) -> None:
    corner, _, reported = depths(world, maximal, 20)
    # Both are differences of lengths of 0.1 m, in the double precision that pybullet is built with.
    np.testing.assert_allclose(reported[1:], corner[:-1], rtol=0, atol=1e-12)
    # The two differ by what is righted in a step: 8 % of the depth and more, while the cube is lifted back.
    assert np.all(reported[1:] > 1.05 * corner[1:])


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_a_cube_set_down_stands_less_deep_than_a_step_of_free_fall(world: World, maximal: int) -> None:
    corner, centre, _ = depths(world, maximal, 480)
    fall = G / 240**2
    # One corner touches first, so that it is the cube's turn that makes it deep, not its sink: the centre stays above the fall.
    assert 0.6 * fall < centre.max() < fall < corner.max() < 1.5 * fall
    # What is left is the contact slop of 1e-5 m, which is not righted, and what gravity adds to it in a step.
    assert corner[-1] < 2e-5


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_a_body_rests_as_deep_as_the_contact_slop_and_not_at_all_deep_without_one(maximal: int) -> None:
    sunk = {}
    for slop in (1e-5, 0.0):
        with World() as world:
            world.setPhysicsEngineParameter(fixedTimeStep=1 / 960, numSolverIterations=200, contactSlop=slop)
            world.setGravity(0.0, 0.0, -G)
            world.body(world.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), maximal, lateralFriction=1.0)
            cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
            body = world.body(cube, 1.0, (0, 0, HALF), maximal, lateralFriction=0.5)
            for _ in range(2 * 960):
                world.stepSimulation()
            sunk[slop] = HALF - world.getBasePositionAndOrientation(body)[0][2]
    # A step of free fall, g dt^2 = 1.06e-5 m, and ERP between slop and surface: both ends within a tenth of the slop.
    assert sunk[1e-5] == pytest.approx(1e-5, abs=1e-6)
    assert abs(sunk[0.0]) < 1e-6


@pytest.mark.parametrize("rate", [960, 1920, 3840])
def test_without_a_contact_slop_a_body_is_never_deeper_than_the_fall_of_its_first_steps(rate: int) -> None:
    """Of second order, at any step: no error that Bullet does not come below, as one with the slop of 1e-5 m is."""
    greatest = {}
    for slop in (1e-5, 0.0):
        with World() as world:
            world.setPhysicsEngineParameter(fixedTimeStep=1 / rate, numSolverIterations=200, contactSlop=slop)
            world.setGravity(0.0, 0.0, -G)
            world.body(world.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), MULTIBODY, lateralFriction=1.0)
            cube = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
            body = world.body(cube, 1.0, (0, 0, HALF), MULTIBODY, lateralFriction=0.5)
            greatest[slop] = 0.0
            for _ in range(rate):
                world.stepSimulation()
                place, turn = world.getBasePositionAndOrientation(body)
                turned = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3)
                greatest[slop] = max(greatest[slop], -float((CORNERS @ turned.T + place)[:, 2].min()))
    # A step of free fall before the contact shows, and a third more: one corner is found first, and turns the cube.
    assert 1.2 < greatest[0.0] / (G / rate**2) < 1.45
    assert greatest[1e-5] > 1e-5
