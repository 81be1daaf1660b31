"""Balls thrown without spin, in pybullet's own words: what hidden damping takes of the speed that Coulomb's law leaves."""

import math

import pytest

from tests.vendor.bullet_world import MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, DT, MU = 9.81, 1 / 240, 0.3


def rolled(world: World, damped: bool) -> tuple[float, float]:
    """Errors [m/s, rad/s] after 2 s, the worst of four balls of 0.1 m thrown at 5 m/s: sphere, cylinder, shell and hoop."""
    world.setGravity(0, 0, -G)
    world.changeDynamics(world.createMultiBody(0, world.createCollisionShape(pybullet.GEOM_PLANE)), -1, lateralFriction=1)
    balls, levers = [], (0.4, 0.5, 2 / 3, 1.0)
    for k, lever in enumerate(levers):
        shape = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1)
        ball = world.createMultiBody(1.0, shape, basePosition=[0, float(k), 0.1], useMaximalCoordinates=MULTIBODY)
        world.changeDynamics(ball, -1, mass=1.0, localInertiaDiagonal=[lever * 0.01] * 3)
        world.changeDynamics(ball, -1, lateralFriction=MU)
        if not damped:
            world.release(ball, MULTIBODY)
        world.resetBaseVelocity(ball, [5, 0, 0])
        balls.append(ball)
    for _ in range(round(2 / DT)):
        world.stepSimulation()
    off = [0.0, 0.0]
    for ball, lever in zip(balls, levers, strict=True):
        v, w = world.getBaseVelocity(ball)
        due = 5.0 / (1 + lever)
        off = [max(off[0], math.dist(v, (due, 0, 0))), max(off[1], math.dist(w, (0, due / 0.1, 0)))]
    return off[0], off[1]


def test_as_they_come_they_lose_half_of_their_speed(world: World) -> None:
    assert rolled(world, damped=True) == pytest.approx((1.807, 18.07), rel=5e-3)


def test_without_damping_they_roll_as_fast_as_coulomb_says(world: World) -> None:
    # The step in which slip ends may rub on for all of its length: mu g dt, and 1/(k r) times that in spin.
    v, w = rolled(world, damped=False)
    assert v < MU * G * DT
    assert w < MU * G * DT / (0.4 * 0.1)
