"""Boxes on inclines around the angle of friction: which hold, which slide, and how fast?

A box slides iff tan(angle) > mu, and then with a = g (sin(angle) - mu cos(angle)).
Source: Coulomb's law; Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3.
"""

import math

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G, forces_obey_coulomb
from plumbline.harness.metrics import slide, statics
from plumbline.harness.scene import Body, Box, Effect, Scene, Surface, axis_angle, rotate
from plumbline.harness.trajectory import Floats, Trajectory

MASS, SPACING, DURATION = 1.0, 1.0, 1.0
STEEPNESS = (0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.01, 1.02, 1.03, 1.05, 1.1, 1.2, 1.5)
"""tan(angle)/mu of the inclines: densest at the threshold, which is never one of them."""
HALF = (0.1, 0.1, 0.025)
THICKNESS, WIDTH = 0.2, 0.3
"""Half extents [m] of an incline along its normal and across the fall line."""


class P(Parameters):
    steepness: tuple[float, ...] = STEEPNESS
    friction: Positive = 0.5


def _acceleration(steepness: float, friction: float) -> float:
    """Down the incline [m/s2], 0 where the box holds."""
    angle = math.atan(steepness * friction)
    return max(0.0, G * (math.sin(angle) - friction * math.cos(angle)))


def scene(p: P) -> Scene:
    """One incline with a box at rest on it for each steepness, side by side along y; down is towards +x."""
    # Each incline is long enough for twice the way that its box has in truth.
    bodies = []
    for i, steep in enumerate(p.steepness):
        turn = axis_angle((0.0, 1.0, 0.0), math.atan(steep * p.friction))
        length = 5 * HALF[0] + _acceleration(steep, p.friction) * DURATION**2
        below = rotate(turn, (0.0, 0.0, -THICKNESS - HALF[2]))
        here, incline = (0.0, SPACING * i, 0.0), Box(half_extents=(length, WIDTH, THICKNESS))
        bodies += [
            Body.fixed(f"incline_{i}", incline, material="incline", p_WB=(below[0], here[1], below[2]), q_WB=turn),
            Body.box(f"box_{i}", HALF, mass=MASS, material="box", p_WB=here, q_WB=turn),
        ]
    return Scene(
        bodies=tuple(bodies),
        surfaces=(Surface.rough(p.friction, ("box", "incline")),),
        apart=(("box", "box"),),
        # Boxes that slide flat never turn, so that no gyroscopic torque is asked for.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: at rest, or uniformly accelerated down the incline."""
    stage = scene(p)
    truth = Trajectory.at_rest(stage, time)
    for place, body in enumerate(stage.bodies):
        if body.movable:
            a = _acceleration(p.steepness[place // 2], p.friction)
            down = rotate(body.q_WB, (1.0, 0.0, 0.0))
            truth.p_WB[:, place] += np.outer(a * truth.time**2 / 2, down)
            truth.v_WB[:, place] = np.outer(a * truth.time, down)
    return truth


CASE = Case.of(
    globals(),
    title="The angle of friction",
    question="At which angle does a box begin to slide, how fast does it slide beyond, and does it stay put below?",
    source="Meriam and Kraige, Engineering Mechanics: Statics, 7th ed., section 6/3",
    truth="closed form",
    checks=(
        Check(
            statics.threshold_angle_error,
            0.01,
            "the inclines next to the threshold stand 1 % of mu to both sides; if they are told apart the middle lies "
            "within 0.1 % of it, and if not, the next bracket's lies 1.2 % off",
        ),
        Check(
            statics.incline_acceleration_error,
            lambda dt, p: 2 * max(p.steepness) * p.friction * dt / DURATION,
            "the first step may pass before there is a contact to rub: a speed g sin(angle) dt that stays, which 2 "
            "s/t^2 sees as an acceleration of 2 g sin(angle) dt/t; sin < tan = 0.75 at the steepest",
        ),
        Check(
            slide.creep_speed,
            lambda _dt, p: 0.1 * _acceleration(min(steep for steep in p.steepness if steep > 1.0), p.friction) * DURATION / 2,
            "a tenth of the mean speed of the slowest slider, 1 % over the threshold: creep is never taken for sliding",
            start=DURATION / 2,
        ),
        *forces_obey_coulomb(),
    ),
    headline="incline_acceleration_error",
    converges="once",
)
