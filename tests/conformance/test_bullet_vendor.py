"""What Bullet itself does, told in pybullet's own words: the facts that the adapter's choices and deviations rest on.

Nothing of the adapter is used here. A newer pybullet that fails one of these tests has changed the fact that it names.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

G = 9.81
MULTIBODY, MAXIMAL = 0, 1
SPLIT = {"useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0}
"""Penetration is corrected apart from velocity (maximal coordinates alone have that)."""


class World:
    """A private world of pybullet, every call with its client."""

    def __init__(self) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **named: getattr(pybullet, name)(*arguments, **named, physicsClientId=self.client)

    def body(self, shape: int, mass: float, position: tuple[float, float, float], maximal: int, **dynamics: Any) -> int:
        """A body of a collision shape without damping, sleeping and clamp."""
        number: int = self.createMultiBody(mass, shape, basePosition=position, useMaximalCoordinates=maximal)
        if mass > 0:
            dynamics |= {"mass": mass, "localInertiaDiagonal": [mass / 150] * 3}
            self.changeDynamics(number, -1, linearDamping=0.0, angularDamping=0.0)
            if maximal == MULTIBODY:
                self.changeDynamics(number, -1, maxJointVelocity=1e30)
            else:
                self.changeDynamics(number, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        self.changeDynamics(number, -1, **dynamics)
        return number


@pytest.fixture
def world() -> Iterator[World]:
    made = World()
    yield made
    made.disconnect()


def rebound(world: World, dt: float, phase: float, maximal: int, **engine: float) -> float:
    """The speed after over the speed before of a ball of e = 1 that meets the ground at 1 m/s, `phase` into a step."""
    world.setPhysicsEngineParameter(fixedTimeStep=dt, restitutionVelocityThreshold=0.01, **SPLIT, **engine)
    settings = {"restitution": 1.0, "lateralFriction": 0.0, "contactProcessingThreshold": 0.0}
    world.body(world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5]), 0.0, (0, 0, -0.5), maximal, **settings)
    ball = world.body(
        world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1), 1.0, (0, 0, 0.1 + (10 + phase) * dt), maximal, **settings
    )
    world.resetBaseVelocity(ball, [0, 0, -1.0])
    for _ in range(20):
        world.stepSimulation()
    return float(world.getBaseVelocity(ball)[0][2])


def test_a_rebound_loses_the_contact_slop_over_the_time_step(world: World) -> None:
    # Found 0.1 dt v = 2e-6 m deep, within the slop of 1e-5 m: (1e-5 - 2e-6)/2e-5 = 0.4 m/s are lost.
    assert rebound(world, 2e-5, 0.9, MAXIMAL, contactSlop=1e-5) == pytest.approx(0.6, abs=1e-6)


def test_a_rebound_is_whole_without_contact_slop(world: World) -> None:
    assert rebound(world, 2e-5, 0.9, MAXIMAL, contactSlop=0.0) == pytest.approx(1.0, abs=1e-6)


def test_a_rebound_in_multibody_coordinates_gains_its_share_of_the_depth(world: World) -> None:
    # Found 0.9 dt v deep: contact ERP 0.08 takes 0.08 * 0.9 v out of it by velocity.
    assert rebound(world, 1e-3, 0.1, MULTIBODY, contactSlop=0.0, contactERP=0.08) == pytest.approx(1.072, abs=1e-6)


def test_a_contact_point_left_alone_keeps_the_impulse_of_an_earlier_step(world: World) -> None:
    dt, speed, e = 1e-3, 3.0, 0.5
    world.setPhysicsEngineParameter(fixedTimeStep=dt, contactSlop=0.0, **SPLIT)
    settings = {"restitution": math.sqrt(e), "contactProcessingThreshold": 0.0}
    world.body(world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5]), 0.0, (0, 0, -0.5), MAXIMAL, **settings)
    ball = world.body(world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1), 2.0, (0, 0, 0.102), MAXIMAL, **settings)
    world.resetBaseVelocity(ball, [0, 0, -speed])
    touching, apart = 0.0, 0.0
    for _ in range(40):
        world.stepSimulation()
        for point in world.getContactPoints():
            if point[8] <= 0:
                touching += point[9] * dt
            else:
                apart += point[9] * dt
    # What acts is m (1 + e) v = 9 N s, in the step that finds the ball 1 mm deep; then it leaves by 1.5 mm a step, and each
    # step until it is out of reach reports the same impulse anew.
    assert touching == pytest.approx(2.0 * (1 + e) * speed, rel=1e-9)
    assert apart > touching


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
        world = World()
        try:
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
        finally:
            world.disconnect()
    # b m g/I t = 0.002 * 9.81/(1/150) * 0.1; the ball settles into the slop in the first steps, 1 % of the time.
    assert rates[MULTIBODY] == pytest.approx(20 - 0.1 * 0.002 * G * 150, abs=0.003)
    assert rates[MAXIMAL] == pytest.approx(20.0, abs=1e-9)


def test_the_mass_matrix_of_some_trees_is_refused(world: World) -> None:
    """Rounding leaves the inertia of a body about its joint unsymmetric by an ulp, which the binding takes for an error."""
    draw, refused = np.random.default_rng(1), 0

    def turns(count: int) -> list[list[float]]:
        q = draw.normal(size=(count, 4))
        made: list[list[float]] = (q / np.linalg.norm(q, axis=1, keepdims=True)).tolist()
        return made

    for _ in range(200):
        axes = draw.normal(size=(3, 3))
        tree = world.createMultiBody(
            baseMass=0.0,
            linkMasses=[1.0] * 3,
            linkCollisionShapeIndices=[-1] * 3,
            linkVisualShapeIndices=[-1] * 3,
            linkPositions=draw.normal(size=(3, 3)).tolist(),
            linkOrientations=turns(3),
            linkInertialFramePositions=draw.normal(size=(3, 3)).tolist(),
            linkInertialFrameOrientations=[[0, 0, 0, 1]] * 3,
            linkParentIndices=[0, 1, 2],
            linkJointTypes=[pybullet.JOINT_REVOLUTE] * 3,
            linkJointAxis=(axes / np.linalg.norm(axes, axis=1, keepdims=True)).tolist(),
        )
        for link in range(3):
            world.changeDynamics(tree, link, mass=1.0 + link, localInertiaDiagonal=[0.1, 0.2, 0.25])
        try:
            world.calculateMassMatrix(tree, [0.1, 0.2, 0.3])
        except (pybullet.error, SystemError):
            refused += 1
    # One tree in forty or so: 200 hold five on average, and the numbers are the same each time.
    assert refused > 0


@pytest.mark.parametrize(("maximal", "least", "most"), [(MULTIBODY, 1.0 - 1e-9, 1.0 + 1e-9), (MAXIMAL, 1.02, math.sqrt(2))])
def test_maximal_coordinates_report_friction_beyond_mu_n(world: World, maximal: int, least: float, most: float) -> None:
    """The greatest T/(mu N) of the points of a box that slides down a box, sqrt(2) being the corner of two bounds apart."""
    mu = 0.5
    world.setGravity(G * math.sin(0.6), 0.0, -G * math.cos(0.6))
    world.setPhysicsEngineParameter(fixedTimeStep=1 / 240, numSolverIterations=200, solverResidualThreshold=0.0)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5])
    world.body(slab, 0.0, (0, 0, -0.5), maximal, lateralFriction=1.0)
    flat = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.2, 0.05])
    world.body(flat, 1.0, (0, 0, 0.05), maximal, lateralFriction=mu)
    shares = []
    for _ in range(120):
        world.stepSimulation()
        shares += [math.hypot(c[10], c[12]) / (mu * c[9]) for c in world.getContactPoints() if c[9] > 0.01 * G]
    assert least < max(shares) < most
