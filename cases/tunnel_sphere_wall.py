"""Small spheres shot at a thin wall, each caught at another phase of the time step.

Whether a discrete test sees the wall depends on where in its step the sphere arrives. One shot says little, so every
sphere starts its own random way before the wall, uniform over speed/60: a whole number of steps' ways for each time
step that divides 1/60 s, which makes the phase uniform over a step.
Source: Ericson, Real-Time Collision Detection, section 2.4.3; Wilson, J. Amer. Statist. Assoc. 22 (1927) 209.
"""

import numpy as np

from plumbline.harness.case import Axis, Case, Check, Count, Parameters, Positive
from plumbline.harness.metrics import passage
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

THICKNESS, RADIUS, MASS = 0.01, 0.05, 1.0
SPACING, CLEARANCE, DURATION = 1.0, 0.05, 0.25


class P(Parameters):
    speed: Positive = 50.0
    phases: Count = 64
    thickness: Positive = THICKNESS
    continuous: bool = True
    seed: int = 0


def _starts(speed: float, phases: int, seed: int) -> Floats:
    """Ways (phases,) m from the front of each sphere to the face of the wall."""
    if CLEARANCE / speed + 1 / 60 > DURATION / 2:
        raise ValueError(f"tunnel_sphere_wall: speed {speed} m/s, expected at least {CLEARANCE / (DURATION / 2 - 1 / 60):.3g}")
    return CLEARANCE + np.random.default_rng(seed).uniform(0.0, speed / 60, phases)


def scene(p: P) -> Scene:
    """`phases` spheres side by side along y, flying along x at `speed` [m/s] at a wall `thickness` [m] thick; no gravity.

    `continuous` calls for continuous collision detection; an engine that lacks it, or leaves it off by default, runs without
    and says so, and with False every engine gives what its plain contacts give.
    """
    spheres = [
        Body.ball(
            f"sphere_{i}",
            RADIUS,
            mass=MASS,
            material="sphere",
            p_WB=(-float(way) - RADIUS, SPACING * i, 0.0),
            v_WB=(p.speed, 0.0, 0.0),
        )
        for i, way in enumerate(_starts(p.speed, p.phases, p.seed))
    ]
    middle = SPACING * (p.phases - 1) / 2
    wall = Body.fixed(
        "wall", Box(half_extents=(p.thickness / 2, middle + SPACING, 0.5)), material="wall", p_WB=(p.thickness / 2, middle, 0.0)
    )
    return Scene(
        bodies=(wall, *spheres),
        surfaces=(Surface(between=("sphere", "wall")),),
        gravity=(0.0, 0.0, 0.0),
        apart=(("sphere", "sphere"),),
        widen=Effect.CONTINUOUS_COLLISION if p.continuous else Effect.NONE,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: straight flight, then rest at the face of the wall (no restitution)."""
    truth = Trajectory.at_rest(scene(p), time)
    for place, way in enumerate(_starts(p.speed, p.phases, p.seed), start=1):
        truth.p_WB[:, place, 0] += np.minimum(p.speed * truth.time, way)
        truth.v_WB[:, place, 0] = np.where(p.speed * truth.time < way, p.speed, 0.0)
    return truth


CASE = Case.of(
    globals(),
    title="Spheres shot at a thin wall",
    question="With what probability does a fast sphere get through a thin wall, and how deep is it left if it does not?",
    source="Ericson, Real-Time Collision Detection, section 2.4.3",
    truth="closed form",
    hard=Axis(parameter="speed", unit="m/s", easy=1, extreme=500, lost=0.0),
    checks=(
        Check(
            passage.tunnel_probability,
            0.0,
            "a wall lets no sphere through, at any phase: no centre ends beyond its middle; 0 of 64 put the "
            "probability under 5.7 % (Wilson, 95 %)",
        ),
    ),
    observe=(passage.tunnel_probability_low, passage.tunnel_probability_high, passage.sink_depth, passage.stop_gap),
    eased={"wall four times as thick": {"thickness": 4 * THICKNESS}},
)
