"""The same box pushed in thirteen directions: friction has no favourite axis.

All boxes lie alike; only the azimuth of the push changes. Each stops after v0^2/(2 mu g). A friction cone that is
approximated by a pyramid along fixed axes makes diagonal pushes stop after 0.71 or 1.41 of that.
Source: Stewart, SIAM Review 42 (2000) 3 (polyhedral approximations of the friction cone).
"""

import math
from typing import Annotated

import numpy as np
from annotated_types import Ge

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import G, forces_keep_momentum, forces_obey_coulomb
from plumbline.harness.metrics.slide import centre_rise, heading_error, polar_spread, stop_distance_error
from plumbline.harness.scene import Body, Effect, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

MASS = 1.0
HALF = (0.1, 0.1, 0.025)
"""Half extents [m], flat enough that no push tips a box."""


class P(Parameters):
    directions: Annotated[int, Ge(2)] = 13
    friction: Positive = 0.5
    speed: Positive = 2.0


def _azimuths(directions: int) -> list[float]:
    """Evenly spaced from 0 to pi/2, both ends included [rad]."""
    return [math.pi / 2 * i / (directions - 1) for i in range(directions)]


def _spacing(friction: float, speed: float) -> float:
    """Distance of neighbours [m], a box more than any way."""
    return speed**2 / (2 * friction * G) * 1.5 + 4 * HALF[0]


def scene(p: P) -> Scene:
    """`directions` boxes in a row along y, touching the ground, pushed at `speed` [m/s] at azimuths from x to y."""
    boxes = [
        Body.box(
            f"box_{i}",
            HALF,
            mass=MASS,
            material="box",
            p_WB=(0.0, _spacing(p.friction, p.speed) * i, HALF[2]),
            v_WB=(p.speed * math.cos(azimuth), p.speed * math.sin(azimuth), 0.0),
        )
        for i, azimuth in enumerate(_azimuths(p.directions))
    ]
    return Scene(
        bodies=(Body.ground(), *boxes),
        surfaces=(Surface.rough(p.friction, ("box", "ground")),),
        apart=(("box", "box"),),
        # Boxes that slide flat never turn, so that no gyroscopic torque is asked for.
        narrow=Effect.GYROSCOPIC,
    )


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: uniform deceleration along each push, then rest."""
    truth = Trajectory.at_rest(scene(p), time)
    sliding = np.minimum(truth.time, p.speed / (p.friction * G))
    way, rate = p.speed * sliding - p.friction * G * sliding**2 / 2, p.speed - p.friction * G * sliding
    for i, azimuth in enumerate(_azimuths(p.directions), start=1):
        push = (math.cos(azimuth), math.sin(azimuth))
        truth.p_WB[:, i, :2] += np.outer(way, push)
        truth.v_WB[:, i, :2] = np.outer(rate, push)
    return truth


def _step(dt: float, p: P) -> float:
    """One step's way v0 dt as a share of the whole one, v0^2/(2 mu g)."""
    return p.speed * dt / (p.speed**2 / (2 * p.friction * G))


CASE = Case.of(
    globals(),
    title="Friction in every direction",
    question="Does the stopping distance depend on the azimuth of the push?",
    source="Stewart, SIAM Review 42 (2000) 3",
    truth="closed form",
    duration=0.75,
    checks=(
        Check(
            polar_spread,
            _step,
            "each way is uncertain by half a step's way v0 dt/2 to both sides, so two differ by at most v0 dt; "
            "relative to v0^2/(2 mu g)",
        ),
        Check(
            heading_error,
            _step,
            "friction opposes the velocity, so the path is straight; were it turned across for one whole step, the box "
            "would end v0 dt aside",
        ),
        Check(
            stop_distance_error,
            lambda dt, p: 1.5 * _step(dt, p),
            "half a step's way by a staggered scheme, one step's way before there is a contact to rub",
        ),
        forces_keep_momentum(),
        *forces_obey_coulomb(),
    ),
    observe=(centre_rise,),
)
