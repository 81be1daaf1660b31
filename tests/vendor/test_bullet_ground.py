"""A ground that is a plane and one that is a box, as pybullet_data's own plane.urdf is, in pybullet's own words."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, HALF, COARSE = 9.81, 0.1, 1 / 15
STARTS = 16
BOTH = pytest.mark.parametrize("coordinates", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
PLANE: dict[str, Any] = {"shapeType": pybullet.GEOM_PLANE, "planeNormal": [0, 0, 1]}
REACH = 1000.0
SLAB: dict[str, Any] = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [REACH] * 3}
CUBE: dict[str, Any] = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [HALF] * 3}
CYLINDER: dict[str, Any] = {"shapeType": pybullet.GEOM_CYLINDER, "radius": HALF, "height": 2 * HALF}
HULL: dict[str, Any] = {
    "shapeType": pybullet.GEOM_MESH,
    "vertices": [[x, y, z] for x in (-HALF, HALF) for y in (-HALF, HALF) for z in (-HALF, HALF)],
}


def on(world: World, ground: dict[str, Any], coordinates: int) -> None:
    """A ground at z = 0, under 200 iterations."""
    world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=0.0)
    level = -REACH if ground is SLAB else 0.0
    world.body(world.createCollisionShape(**ground), 0.0, (0.0, 0.0, level), coordinates, lateralFriction=1.0)


def test_the_plane_that_pybullet_brings_along_is_a_box() -> None:
    data = pytest.importorskip("pybullet_data")
    with World() as world:
        body = world.loadURDF(str(Path(data.getDataPath()) / "plane.urdf"))
        (shape,) = world.getCollisionShapeData(body, -1)
    assert shape[2] == pybullet.GEOM_BOX
    assert shape[3] == (200.0, 200.0, 10.0)


def standing(ground: dict[str, Any], coordinates: int) -> int:
    """Of STARTS single cubes, turned about the vertical, how many stand for 5 s at steps of 1/15 s."""
    stand = 0
    for start in range(STARTS):
        with World() as world:
            on(world, ground, coordinates)
            world.setPhysicsEngineParameter(fixedTimeStep=COARSE)
            world.setGravity(0.0, 0.0, -G)
            cube = world.body(world.createCollisionShape(**CUBE), 1.0, (0.0, 0.0, HALF), coordinates, lateralFriction=0.5)
            yaw = float(np.random.default_rng(start).uniform(0.0, 2 * math.pi)) if start else 0.0
            turn = pybullet.getQuaternionFromEuler([0.0, 0.0, yaw])
            world.resetBasePositionAndOrientation(cube, [0.0, 0.0, HALF], turn)
            least = HALF
            for _ in range(round(5 / COARSE)):
                world.stepSimulation()
                least = min(least, float(world.getBasePositionAndOrientation(cube)[0][2]))
        stand += least > HALF / 2
    return stand


@BOTH
def test_a_cube_at_a_15th_falls_through_a_plane_and_stands_on_a_box(coordinates: int) -> None:
    assert standing(PLANE, coordinates) == 0
    assert standing(SLAB, coordinates) == STARTS


def way(ground: dict[str, Any], shape: dict[str, Any], coordinates: int, dt: float = 1 / 240) -> float:
    """The way in 1 s down 1.1 times the critical slope of mu 0.5 over the due one."""
    with World() as world:
        on(world, ground, coordinates)
        world.setPhysicsEngineParameter(fixedTimeStep=dt)
        slope = math.atan(0.55)
        world.setGravity(G * math.sin(slope), 0.0, -G * math.cos(slope))
        body = world.body(world.createCollisionShape(**shape), 2.0, (0.0, 0.0, HALF), coordinates, lateralFriction=0.5)
        for _ in range(round(1 / dt)):
            world.stepSimulation()
        due = 0.5 * G * (math.sin(slope) - 0.5 * math.cos(slope))
        return float(world.getBasePositionAndOrientation(body)[0][0]) / due


@BOTH
@pytest.mark.parametrize(
    ("shape", "right", "wrong"), [(CUBE, SLAB, PLANE), (CYLINDER, PLANE, SLAB)], ids=["cube", "cylinder on its end"]
)
def test_a_cube_slides_right_on_a_box_and_a_cylinder_on_a_plane(
    shape: dict[str, Any], right: dict[str, Any], wrong: dict[str, Any], coordinates: int
) -> None:
    # Semi-implicit Euler goes 1 + dt/t of the way; a hundredth of mu would be a tenth of what is left to drive it.
    assert way(right, shape, coordinates) == pytest.approx(1 + 1 / 240, abs=0.01)
    assert way(wrong, shape, coordinates) != pytest.approx(1.0, abs=0.08)


def test_a_hull_slides_better_on_a_box() -> None:
    assert 1.0 < way(SLAB, HULL, MULTIBODY) < way(PLANE, HULL, MULTIBODY)


def resting(ground: dict[str, Any], coordinates: int) -> tuple[float, float]:
    """Of a cube set down, at 1/240 s: the depth of its deepest corner in 2 s [m], and how far it has crept by then [m]."""
    corners = HALF * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    with World() as world:
        on(world, ground, coordinates)
        world.setGravity(0.0, 0.0, -G)
        cube = world.body(world.createCollisionShape(**CUBE), 1.0, (0.0, 0.0, HALF), coordinates, lateralFriction=0.5)
        deepest = 0.0
        for _ in range(480):
            world.stepSimulation()
            place, turn = world.getBasePositionAndOrientation(cube)
            turned = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3)
            deepest = max(deepest, -float((corners @ turned.T + place)[:, 2].min()))
        return deepest, math.hypot(*place[:2])


@BOTH
def test_a_cube_is_held_on_a_box_at_once_and_tilts_into_a_plane(coordinates: int) -> None:
    on_plane, on_box = resting(PLANE, coordinates), resting(SLAB, coordinates)
    # A plane shows one corner a step, so that the others fall on: by more than g dt^2. A box shows all in the first step.
    assert on_plane[0] > G / 240**2 / 2 + 1e-5
    assert on_box[0] < 1.2e-5
    assert on_box[1] < on_plane[1] / 5


def test_a_ball_rolls_on_a_box_of_two_kilometres_as_on_a_plane() -> None:
    places = []
    for ground in (PLANE, SLAB):
        with World() as world:
            on(world, ground, MULTIBODY)
            world.setGravity(0.0, 0.0, -G)
            shape = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=HALF)
            ball = world.createMultiBody(1.0, shape, basePosition=[0.0, 0.0, HALF])
            world.changeDynamics(ball, -1, lateralFriction=0.5, mass=1.0, localInertiaDiagonal=[0.4 * HALF**2] * 3)
            world.release(ball, MULTIBODY)
            world.resetBaseVelocity(ball, [3.0, 1.0, 0.0], [0.0, 0.0, 0.0])
            for _ in range(480):
                world.stepSimulation()
            places.append(world.getBasePositionAndOrientation(ball)[0])
    assert places[0] == pytest.approx(places[1], abs=1e-9)
