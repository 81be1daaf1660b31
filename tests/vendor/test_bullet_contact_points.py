"""What `getContactPoints` tells and what it does not, in pybullet's own words."""

import math
from typing import Any

import pytest

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G = 9.81


def test_a_contact_point_left_alone_keeps_the_impulse_of_an_earlier_step(world: World) -> None:
    dt, speed, e = 1e-3, 3.0, 0.5
    world.setPhysicsEngineParameter(fixedTimeStep=dt, contactSlop=0.0, useSplitImpulse=1, splitImpulsePenetrationThreshold=0.0)
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


def test_asked_for_a_body_pybullet_turns_the_normal_of_a_contact_round_and_leaves_its_friction(world: World) -> None:
    """Told of all contacts, the force on the first body is right; asked for one, friction has the sign of the other order."""
    world.setGravity(3.0, 0.0, -G)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[5, 5, 0.5])
    ground = world.createMultiBody(0.0, slab, basePosition=[0, 0, -0.5])
    shape = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1, 0.1, 0.05])
    box = world.createMultiBody(1.0, shape, basePosition=[0, 0, 0.05])
    for body, friction in ((ground, 1.0), (box, 0.5)):
        world.changeDynamics(body, -1, lateralFriction=friction)
    for _ in range(100):
        world.stepSimulation()

    def told(points: Any) -> tuple[int, float, float]:
        """The first body, and the normal force [N] and friction along x [N] that it is told to get."""
        normal = sum(c[9] * c[7][2] for c in points)
        return points[0][1], normal, sum(c[10] * c[11][0] + c[12] * c[13][0] for c in points)

    # The box is pulled along x by 3 N, and drags the ground along by as much; so what it gets itself is -3 N.
    assert told(world.getContactPoints()) == (ground, pytest.approx(-G, rel=1e-3), pytest.approx(3.0, rel=1e-3))
    assert told(world.getContactPoints(box)) == (box, pytest.approx(G, rel=1e-3), pytest.approx(3.0, rel=1e-3))


def test_friction_may_be_left_on_a_point_that_bears_nothing(world: World) -> None:
    """With it what the contacts report is what the ball gains; without it a share is missing."""
    dt = 1 / 60
    world.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=200, solverResidualThreshold=0.0)
    world.setGravity(0.0, 0.0, -G)
    slab = world.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[20, 20, 0.5])
    world.body(slab, 0.0, (0, 0, -0.5), MAXIMAL, lateralFriction=1.0)
    ball = world.body(
        world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1), 1.0, (0, 0, 0.1), MAXIMAL, lateralFriction=0.3
    )
    world.changeDynamics(ball, -1, mass=1.0, localInertiaDiagonal=[0.4 * 0.1**2] * 3)
    world.resetBaseVelocity(ball, [2.0, 0.0, 0.0], [0.0, -60.0, 0.0])
    before, whole, bearing = 2.0, 0.0, 0.0
    for _ in range(60):
        world.stepSimulation()
        after = world.getBaseVelocity(ball)[0][0]
        rubs = []
        for c in world.getContactPoints():
            # On the ball, which is the first or the second of the pair.
            sign = 1.0 if c[1] == ball else -1.0
            rubs.append((c[9], sign * (c[10] * c[11][0] + c[12] * c[13][0])))
        gained = (after - before) / dt
        whole = max(whole, abs(gained - sum(rub for _, rub in rubs)))
        bearing = max(bearing, abs(gained - sum(rub for load, rub in rubs if load > 0)))
        before = after
    assert whole < 1e-9 * G
    assert bearing > 0.01 * G


def test_the_gap_at_which_points_are_let_go_is_one_for_all_worlds_of_a_process(world: World) -> None:
    """Told to one world, it is every other one's, though each is a client of its own: a cube slides another way there."""

    def way(breaks: float | None) -> float:
        with World() as own:
            if breaks is not None:
                own.setPhysicsEngineParameter(contactBreakingThreshold=breaks)
            slope = 0.5
            own.setGravity(G * math.sin(slope), 0.0, -G * math.cos(slope))
            own.body(own.createCollisionShape(pybullet.GEOM_PLANE), 0.0, (0, 0, 0), MULTIBODY, lateralFriction=0.5)
            shape = own.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.1] * 3)
            cube = own.body(shape, 1.0, (0, 0, 0.1), MULTIBODY, lateralFriction=1.0)
            for _ in range(240):
                own.stepSimulation()
            return float(own.getBasePositionAndOrientation(cube)[0][0])

    usual = way(None)
    other = way(0.001)
    assert other != usual
    assert way(None) == other
    world.setPhysicsEngineParameter(contactBreakingThreshold=0.02)
    assert way(None) == usual
