"""Tumbling cubes that fly at each other without gravity: whatever their blows do, momentum and angular momentum stay.

A cube has the same inertia about every axis, so that it tumbles at a constant rate between its blows, and nothing but the
contacts can touch the angular momentum: impulses with unequal arms, or bodies that are moved apart without an impulse.
"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, NotNegative, Parameters
from plumbline.harness.case.bounds import forces_keep_momentum
from plumbline.harness.metrics import conservation, overlaps
from plumbline.harness.scene import Body, Scene, Surface, axis_angle

MASS, HALF, AWAY = 1.0, 0.1, 0.5
DURATION = 1.5


class P(Parameters):
    friction: NotNegative = 0.3
    speed: float = 1.0
    spin: float = 4.0
    seed: int = 0


def scene(p: P) -> Scene:
    """Eight cubes from the corners of a larger one, flying at its middle at `speed` [m/s] and turning at `spin` [rad/s].

    Their axes are drawn anew for each seed, and their aim misses the middle by up to half an edge, so that blows are askew.
    """
    draw = np.random.default_rng(p.seed)
    cubes = []
    for i in range(8):
        corner = np.array([1.0 if i >> axis & 1 else -1.0 for axis in range(3)])
        turned, axis = draw.standard_normal(3), draw.standard_normal(3)
        aim = draw.uniform(-HALF, HALF, 3)
        way = aim - AWAY * corner
        cubes.append(
            Body.box(
                f"cube_{i}",
                (HALF, HALF, HALF),
                mass=MASS,
                p_WB=(AWAY * corner).tolist(),
                q_WB=axis_angle((turned[0], turned[1], turned[2]), float(draw.uniform(0, np.pi))),
                v_WB=(p.speed * way / np.linalg.norm(way)).tolist(),
                w_WB=(p.spin * axis / np.linalg.norm(axis)).tolist(),
            )
        )
    return Scene(bodies=tuple(cubes), surfaces=(Surface.rough(p.friction),), gravity=(0.0, 0.0, 0.0))


CASE = Case.of(
    globals(),
    title="Tumbling cubes collide",
    question="Do momentum and angular momentum stay when tumbling bodies hit and rub each other?",
    source="conservation of momentum and angular momentum (Goldstein, Classical Mechanics, 3rd ed., section 1.2)",
    truth="conservation",
    # Slower cubes would not meet: to its aim a cube has at most sqrt(3) (AWAY + HALF) = 1.04 m to go, and eight aims within a
    # cube of edge 2 HALF leave no room for eight balls of radius HALF, which the cubes hold. Faster ones would skip each other
    # within a step of 1/60 s and never be seen to overlap.
    hard=Axis(parameter="speed", unit="m/s", easy=0.7, extreme=10.0, lost=0.1),
    sample_interval=0.0,
    checks=(
        Check(overlaps.pairs_met, 1.0, "the question is what a blow does: where no two cubes meet, none is asked"),
        Check(
            overlaps.inscribed_overlap,
            lambda dt, p: 2 * (p.speed + np.sqrt(3) * HALF * p.spin) * dt,
            "cubes do not pass through each other; one step's way at the greatest speed of closing, that of two "
            "corners, may lie between the touch and its discovery. Without this, bodies that never touch would pass",
        ),
        Check(
            conservation.momentum_drift_max,
            lambda _, p: 1e-6 * 8 * MASS * p.speed,
            "a blow gives to one what it takes from the other; 1e-6 of all momentum there is, single precision",
        ),
        Check(
            conservation.angular_momentum_drift_max,
            1e-6,
            "a blow and its reaction act at one point, and cubes tumble at a constant rate in between; 1e-6 for single "
            "precision. What moves bodies apart without an impulse shifts momentum aside",
        ),
        Check(
            conservation.energy_gain_max,
            1e-6,
            "blows with friction and without restitution make no energy; 1e-6 for single precision",
        ),
        forces_keep_momentum(),
    ),
    observe=(conservation.momentum_drift_final, conservation.angular_momentum_drift_final),
    headline=conservation.angular_momentum_drift_max.name,
)
