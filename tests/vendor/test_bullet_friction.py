"""Friction in both of pybullet's coordinates, in pybullet's own words: on inclines, of gathered points, about the normal."""

import math
from typing import Any

import numpy as np
import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, DT, MU = 9.81, 1 / 240, 0.5
STEEPNESS = (0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.01, 1.02, 1.03, 1.05, 1.1, 1.2, 1.5)
"""tan(angle)/mu of the inclines."""
DOWN = 0.025
"""Half the height of a box [m]."""


def residuals(world: World, coordinates: int) -> tuple[float, float, float]:
    """Of a box on each incline for a second, over the weight of all: the greatest sums of |T| - mu N, and of |T + mu N u/|u||
    over those that slide at u faster than g dt; and the greatest |T|/(mu N) of a point that bears a hundredth of a weight."""
    world.setGravity(0, 0, -G)
    world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=0.0)
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1, 0.1, DOWN])
    pairs = []
    for k, steep in enumerate(STEEPNESS):
        angle = math.atan(MU * steep)
        turn = pybullet.getQuaternionFromEuler([0.0, angle, 0.0])
        length = 0.5 + max(0.0, G * (math.sin(angle) - MU * math.cos(angle)))
        slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[length, 0.3, 0.2])
        below = (-(0.2 + DOWN) * math.sin(angle), k, -(0.2 + DOWN) * math.cos(angle))
        ground = world.createMultiBody(0.0, slab, basePosition=below, baseOrientation=turn, useMaximalCoordinates=coordinates)
        world.changeDynamics(ground, -1, lateralFriction=1.0)
        box = world.createMultiBody(1.0, shape, basePosition=[0, k, 0], baseOrientation=turn, useMaximalCoordinates=coordinates)
        world.changeDynamics(box, -1, lateralFriction=MU, linearDamping=0.0, angularDamping=0.0)
        pairs.append((box, ground))
    beyond, askew, share = 0.0, 0.0, 0.0
    boxes = [box for box, _ in pairs]
    for _ in range(240):
        world.stepSimulation()
        over, off = 0.0, 0.0
        slips = {box: np.array(world.getBaseVelocity(box)[0]) for box in boxes}
        # All at once: asked for a pair in the other order, pybullet turns the normal round and leaves the friction as it is.
        for c in world.getContactPoints():
            rub = c[10] * np.array(c[11]) + c[12] * np.array(c[13])
            over += max(float(np.linalg.norm(rub)) - MU * c[9], 0.0)
            if c[9] > 0.01 * G:
                share = max(share, float(np.linalg.norm(rub)) / (MU * c[9]))
            # What is told is the force on the first body.
            slip = slips[c[1]] if c[1] in slips else -slips[c[2]]
            speed = float(np.linalg.norm(slip))
            if speed > G * DT:
                off += float(np.linalg.norm(rub + MU * c[9] * slip / speed))
        beyond, askew = max(beyond, over / (G * len(pairs))), max(askew, off / (G * len(pairs)))
    return beyond, askew, share


def test_friction_in_maximal_coordinates_is_beyond_mu_n_and_askew_to_the_slip(world: World) -> None:
    beyond, askew, share = residuals(world, MAXIMAL)
    # Published are the worst of every fourth step, 0.040 and 0.050; two bounds apart hold mu N (sqrt(2) - 1) at most.
    assert 0.040 < beyond < MU * (math.sqrt(2) - 1)
    assert 0.050 < askew < MU
    # The corner of two bounds apart.
    assert share == pytest.approx(math.sqrt(2), abs=1e-9)


def test_friction_in_multibody_coordinates_stays_within_mu_n(world: World) -> None:
    """There it is one direction that turns with the slip, so that the forces obey Coulomb's law to rounding."""
    beyond, _, share = residuals(world, MULTIBODY)
    assert beyond < 1e-12
    assert share == pytest.approx(1.0, abs=1e-9)


def turned(world: World, angle: float, coordinates: int) -> tuple[float, float, float]:
    """A box on an incline of 1.15 times the angle of friction, all turned by `angle` [rad] about the vertical, after 1 s.

    Returns: its speed over the due one, the angle [rad] of its way to the fall line, its mean friction over mu N.
    """
    world.setGravity(0.0, 0.0, -G)
    slope = math.atan(1.15 * MU)
    turn = pybullet.multiplyTransforms(
        [0.0] * 3,
        pybullet.getQuaternionFromEuler([0.0, 0.0, angle]),
        [0.0] * 3,
        pybullet.getQuaternionFromEuler([0.0, slope, 0.0]),
    )[1]
    down, across, normal = np.array(world.getMatrixFromQuaternion(turn)).reshape(3, 3).T
    placed = {"baseOrientation": turn, "useMaximalCoordinates": coordinates}
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[10.0, 3.0, 0.2])
    ground = world.createMultiBody(0.0, slab, basePosition=(-0.2 * normal).tolist(), **placed)
    world.changeDynamics(ground, -1, lateralFriction=1.0)
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1, 0.1, DOWN])
    box = world.createMultiBody(1.0, shape, basePosition=(DOWN * normal).tolist(), **placed)
    world.changeDynamics(box, -1, lateralFriction=MU, linearDamping=0.0, angularDamping=0.0)
    shares = []
    for step in range(240):
        world.stepSimulation()
        points = world.getContactPoints()
        rub = sum((c[10] * np.array(c[11]) + c[12] * np.array(c[13]) for c in points), np.zeros(3))
        if step >= 20:
            shares.append(float(np.linalg.norm(rub)) / (MU * sum(c[9] for c in points)))
    v = np.array(world.getBaseVelocity(box)[0])
    due = G * (math.sin(slope) - MU * math.cos(slope))
    return float(np.linalg.norm(v)) / due, math.atan2(float(v @ across), float(v @ down)), float(np.mean(shares))


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 4, 1.2])
def test_in_maximal_coordinates_a_box_slides_right_whatever_way_the_slope_faces(world: World, angle: float) -> None:
    # What the points have beyond mu N between them cancels: their sum is mu N against the slip.
    assert turned(world, angle, MAXIMAL) == pytest.approx((1.0, 0.0, 1.0), abs=2e-3)


def test_in_multibody_coordinates_it_does_where_the_slope_faces_along_an_axis(world: World) -> None:
    assert turned(world, 0.0, MULTIBODY) == pytest.approx((1.0, 0.0, 1.0), abs=2e-3)


@pytest.mark.parametrize(("angle", "faster"), [(0.4, 1.25), (math.pi / 4, 1.7), (1.2, 1.1)])
def test_elsewhere_it_is_braked_by_less_than_mu_n_and_off_its_way(world: World, angle: float, faster: float) -> None:
    speed, off, share = turned(world, angle, MULTIBODY)
    assert speed > faster
    assert abs(off) > math.radians(3.0)
    assert 0.9 < share < 0.985


@pytest.mark.parametrize(("coordinates", "share"), [(MULTIBODY, 1.0), (MAXIMAL, math.sqrt(2))], ids=["multibody", "maximal"])
def test_a_ball_that_slips_down_a_groove_is_braked_by_mu_n_in_multibody_coordinates_alone(
    world: World, coordinates: int, share: float
) -> None:
    """A groove of two faces at 45 degrees, which leans by 0.3 rad: g (sin - sqrt(2) mu cos) along it."""
    mu, lean, radius = 0.05, 0.3, 0.1
    world.setPhysicsEngineParameter(numSolverIterations=200, solverResidualThreshold=0.0)
    world.setGravity(G * math.sin(lean), 0.0, -G * math.cos(lean))
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5.0, 1.0, 0.2])
    for side in (1, -1):
        turn = pybullet.getQuaternionFromEuler([side * math.pi / 4, 0.0, 0.0])
        below = (0.0, side * 0.2 * math.sqrt(0.5), -0.2 * math.sqrt(0.5))
        face = world.createMultiBody(0.0, slab, basePosition=below, baseOrientation=turn, useMaximalCoordinates=coordinates)
        world.changeDynamics(face, -1, lateralFriction=1.0)
    ball = world.createMultiBody(
        1.0,
        world.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius),
        basePosition=(0.0, 0.0, radius * math.sqrt(2)),
        useMaximalCoordinates=coordinates,
    )
    world.changeDynamics(ball, -1, lateralFriction=mu, mass=1.0, localInertiaDiagonal=[0.4 * radius**2] * 3)
    world.release(ball, coordinates)
    for _ in range(240):
        world.stepSimulation()
    points = world.getContactPoints()
    rubbed = [float(np.linalg.norm(c[10] * np.array(c[11]) + c[12] * np.array(c[13]))) for c in points]
    assert [rub / (mu * c[9]) for rub, c in zip(rubbed, points, strict=True)] == pytest.approx([share] * 2, rel=1e-3)
    due = G * (math.sin(lean) - math.sqrt(2) * mu * math.cos(lean))
    # The contact slop of 1e-5 m is passed in the first step.
    right = world.getBaseVelocity(ball)[0][0] == pytest.approx(due, rel=1e-3)
    assert right is (coordinates == MULTIBODY)


def way(world: World, dt: float, shape: dict[str, Any], ground: dict[str, Any], maximal: int) -> float:
    """The way in 1 s down 1.1 times the critical slope of mu 0.5 over the due one."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    slope = math.atan(0.55)
    world.setGravity(G * math.sin(slope), 0.0, -G * math.cos(slope))
    level = 0.0 if ground["shapeType"] == pybullet.GEOM_PLANE else -0.5
    world.body(world.createCollisionShape(**ground), 0.0, (0, 0, level), maximal, lateralFriction=1.0)
    body = world.body(world.createCollisionShape(**shape), 2.0, (0, 0, 0.1), maximal, lateralFriction=0.5)
    for _ in range(round(1 / dt)):
        world.stepSimulation()
    due = 0.5 * G * (math.sin(slope) - 0.5 * math.cos(slope))
    return float(world.getBasePositionAndOrientation(body)[0][0]) / due


CUBE = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [0.1, 0.1, 0.1]}
CYLINDER = {"shapeType": pybullet.GEOM_CYLINDER, "radius": 0.1, "height": 0.2}
PLANE = {"shapeType": pybullet.GEOM_PLANE, "planeNormal": [0, 0, 1]}
SLAB = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [20, 20, 0.5]}


@pytest.mark.parametrize(("shape", "ground"), [(CUBE, PLANE), (CYLINDER, SLAB)], ids=["cube on plane", "cylinder on box"])
@pytest.mark.parametrize("dt", [1 / 240, 1e-3])
def test_maximal_coordinates_brake_what_stands_on_gathered_points_too_much(
    world: World, shape: dict[str, Any], ground: dict[str, Any], dt: float
) -> None:
    # Semi-implicit Euler goes 1 + dt/t of the way, 1.004 at most; 5 % less is no matter of the step.
    assert way(world, dt, shape, ground, MAXIMAL) < 0.95


@pytest.mark.parametrize(("shape", "ground"), [(CUBE, PLANE), (CYLINDER, SLAB)], ids=["cube on plane", "cylinder on box"])
def test_multibody_coordinates_slide_them_nearly_right(world: World, shape: dict[str, Any], ground: dict[str, Any]) -> None:
    # 0.001 is the step's; Bullet's own surplus stays below 3 %, and a tenth of the driving force is mu's tenth of 1.1.
    assert way(world, 1e-3, shape, ground, MULTIBODY) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("maximal", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])
def test_two_boxes_slide_right_in_both_coordinates(world: World, maximal: int) -> None:
    # The step's own surplus is dt/t = 0.001.
    assert way(world, 1e-3, CUBE, SLAB, maximal) == pytest.approx(1.001, abs=1e-3)


@pytest.mark.parametrize("bearer", ["ball", "ground"])
def test_torsional_friction_acts_from_either_body_in_multibody_coordinates_alone(bearer: str) -> None:
    rates = {}
    for maximal in (MULTIBODY, MAXIMAL):
        with World() as world:
            world.setPhysicsEngineParameter(fixedTimeStep=1e-3)
            world.setGravity(0, 0, -G)
            slab = world.createCollisionShape(**SLAB)
            world.body(slab, 0.0, (0, 0, -0.5), maximal, lateralFriction=1.0, spinningFriction=0.002 * (bearer == "ground"))
            sphere = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
            spin = 0.002 * (bearer == "ball")
            ball = world.body(sphere, 1.0, (0, 0, 0.1), maximal, lateralFriction=1.0, spinningFriction=spin)
            world.resetBaseVelocity(ball, [0, 0, 0], [0, 0, 20.0])
            for _ in range(100):
                world.stepSimulation()
            rates[maximal] = world.getBaseVelocity(ball)[1][2]
    # b m g/I t = 0.002 * 9.81/(1/150) * 0.1; the ball settles into the slop in the first steps, 1 % of the time.
    assert rates[MULTIBODY] == pytest.approx(20 - 0.1 * 0.002 * G * 150, abs=0.003)
    assert rates[MAXIMAL] == pytest.approx(20.0, abs=1e-9)
