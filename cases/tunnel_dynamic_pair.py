"""Pairs of small spheres that fly at each other: neither stands still, so that a test against fixed bodies alone misses them.

Whether a discrete test sees a pair depends on where in a step the two meet, so that every pair starts its own random
distance apart, uniform over closing speed/60: a whole number of steps' ways for each step that divides 1/60 s.
Source: Ericson, Real-Time Collision Detection, sections 2.4.3 and 5.5.5 (two moving spheres).
"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Count, Parameters, Positive
from plumbline.harness.metrics import conservation, passage
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

RADIUS, MASS = 0.05, 1.0
SPACING, CLEARANCE, DURATION = 1.0, 0.05, 0.25


class P(Parameters):
    speed: Positive = 50.0
    phases: Count = 64
    continuous: bool = True
    seed: int = 0


def _ways(speed: float, phases: int, seed: int) -> Floats:
    """How far (phases,) m each sphere of a pair flies until the two touch."""
    if CLEARANCE / speed + 1 / 60 > DURATION / 2:
        least = CLEARANCE / (DURATION / 2 - 1 / 60)
        raise ValueError(f"tunnel_dynamic_pair: speed {speed} m/s, expected at least {least:.3g}")
    # Both fly, so that half of the closing way is each one's.
    return CLEARANCE + np.random.default_rng(seed).uniform(0.0, speed / 60, phases)


def scene(p: P) -> Scene:
    """`phases` pairs side by side along y, each sphere flying along x at `speed` [m/s] at the other; no gravity.

    `continuous` calls for continuous collision detection; an engine that lacks it, or leaves it off by default, runs without
    and says so, and with False every engine gives what its plain contacts give.
    """
    spheres = []
    for i, way in enumerate(_ways(p.speed, p.phases, p.seed)):
        for side, name in ((-1.0, "left"), (1.0, "right")):
            spheres.append(
                Body.ball(
                    f"{name}_{i}",
                    RADIUS,
                    mass=MASS,
                    material=name,
                    p_WB=(side * (RADIUS + float(way)), SPACING * i, 0.0),
                    v_WB=(-side * p.speed, 0.0, 0.0),
                )
            )
    return Scene(
        bodies=tuple(spheres),
        surfaces=(Surface(between=("left", "right")),),
        gravity=(0.0, 0.0, 0.0),
        apart=(("left", "left"), ("right", "right")),
        widen=Effect.CONTINUOUS_COLLISION if p.continuous else Effect.NONE,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: straight flight, then rest, face to face (equal masses, no restitution)."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, way in enumerate(_ways(p.speed, p.phases, p.seed)):
        for place, side in ((2 * i, -1.0), (2 * i + 1, 1.0)):
            truth.p_WB[:, place, 0] -= side * np.minimum(p.speed * truth.time, way)
            truth.v_WB[:, place, 0] = np.where(p.speed * truth.time < way, -side * p.speed, 0.0)
    return truth


CASE = Case.of(
    globals(),
    title="Spheres shot at each other",
    question="With what probability do two fast spheres fly through each other, and how deep are others left?",
    source="Ericson, Real-Time Collision Detection, sections 2.4.3 and 5.5.5",
    truth="closed form",
    hard=Axis(parameter="speed", unit="m/s", easy=1, extreme=500, lost=0.0),
    checks=(
        Check(
            passage.passage_probability,
            0.0,
            "two solid spheres stop each other, at any phase: no two centres change sides; 0 of 128 put the "
            "probability under 2.9 % (Wilson, 95 %)",
        ),
        Check(
            conservation.momentum_drift_max,
            lambda _, p: 1e-6 * 2 * p.phases * MASS * p.speed,
            "a stop that is not an impulse on both makes momentum; 1e-6 of all there is, single precision",
        ),
    ),
    observe=(
        passage.passage_probability_low,
        passage.passage_probability_high,
        passage.sink_depth,
        passage.rest_speed,
        passage.lateral_kick,
    ),
)
