"""How pybullet gives balls back that are dropped on the ground, in pybullet's own words."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vendor.bullet_world import MAXIMAL, MULTIBODY, World, pybullet

pytestmark = pytest.mark.bullet

G, DT, RADIUS = 9.81, 1 / 240, 0.1
RESTITUTIONS = (0.0, 0.3, 0.5, 0.8, 0.95, 1.0)
FALL = math.sqrt(2 / G)
"""From a metre [s]."""
SAME = 5e-4
"""The figures are published with four digits; one engine and one scene give them again but for rounding."""
Floats = NDArray[np.float64]
SPLIT = {"useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0}
"""Penetration is corrected apart from velocity (maximal coordinates alone have that)."""


def drop(world: World, **kind: Any) -> Floats:
    """Heights over the plane (t, 6) m of balls of each restitution that are let go a metre over it, for 4.5 s."""
    world.setGravity(0, 0, -G)
    ground = world.createMultiBody(0.0, world.createCollisionShape(pybullet.GEOM_PLANE), **kind)
    world.changeDynamics(ground, -1, restitution=1.0, lateralFriction=0.0)
    shape = world.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS)
    balls = []
    for k, e in enumerate(RESTITUTIONS):
        ball = world.createMultiBody(1.0, shape, basePosition=[0.0, 1.2 * k, 1.0 + RADIUS], **kind)
        world.changeDynamics(ball, -1, restitution=e, lateralFriction=0.0)
        if kind:
            world.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0, contactProcessingThreshold=0.0)
            world.changeDynamics(ball, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        balls.append(ball)
    heights = [[1.0] * len(balls)]
    for _ in range(round(4.5 / DT)):
        world.stepSimulation()
        heights.append([world.getBasePositionAndOrientation(ball)[0][2] - RADIUS for ball in balls])
    return np.array(heights)


def apexes(height: Floats) -> list[float]:
    """The vertices [m] of the parabolas of one ball, the start's first, and that to which it flies at the end."""
    tops = [k for k in range(1, len(height) - 1) if height[k - 1] < height[k] >= height[k + 1]] + [len(height) - 2]
    return [1.0] + [float(height[k] + ((height[k + 1] - height[k - 1]) / (2 * DT)) ** 2 / (2 * G)) for k in tops]


def test_as_it_comes_a_ball_of_e_1_comes_back_lower_and_one_of_0_8_rests_early(world: World) -> None:
    heights = drop(world)
    lost = [abs(apexes(height)[1] - e**2) for e, height in zip(RESTITUTIONS, heights.T, strict=True) if e >= 0.5]
    assert max(lost) == pytest.approx(0.06507, rel=SAME)
    # A ball's hops of more than 1e-4 of the drop: the last lands at t0 (1 + 2 (e + ... + e^n)).
    hops = math.floor(math.log(1e-4) / (2 * math.log(0.8)))
    ends = FALL * (1 + 2 * sum(0.8**n for n in range(1, hops + 1)))
    found = float(np.flatnonzero(heights[:, 3] > 1e-4)[-1]) * DT
    assert ends - found == pytest.approx(1.35, abs=2 * DT)


SETTINGS = {
    "numSolverIterations": 200,
    "solverResidualThreshold": 0.0,
    "restitutionVelocityThreshold": 0.01,
    **SPLIT,
    "contactSlop": 1e-6 * DT,
}
"""What makes rebounds best in maximal coordinates: no slop, no damping, and contacts that wait until they touch."""


@pytest.mark.parametrize(("contact_erp", "gain"), [(0.08, 8.597e-4), (0.0, G * DT**2 / 8)])
def test_at_its_best_a_ball_of_e_1_gains_what_the_correction_of_its_depth_lifts_it(
    world: World, contact_erp: float, gain: float
) -> None:
    """Without that correction nothing is left but the apex of a staggered fall, g dt^2/8 over its start."""
    world.setPhysicsEngineParameter(**SETTINGS, contactERP=contact_erp)
    top = max(max(apexes(height)) for height in drop(world, useMaximalCoordinates=MAXIMAL).T)
    assert top - 1 == pytest.approx(gain, rel=5e-3)


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
