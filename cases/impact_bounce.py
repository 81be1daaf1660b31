"""Balls of different restitution dropped on level ground: how high do they come back?

A ball dropped from h meets the ground at t0 = sqrt(2 h/g) and rises to e^2 h, e^4 h, ...; impact n comes at
t0 (1 + 2 (e + ... + e^n)), and all bouncing ends at t0 (1 + e)/(1 - e).
Source: Stronge, Impact Mechanics, 2nd ed.; Falcon et al., Eur. Phys. J. B 3 (1998) 45.
"""

import math

import numpy as np

from plumbline.harness.case import Case, Check, Parameters, Positive
from plumbline.harness.case.bounds import SPRING_STEPS, G, forces_keep_momentum
from plumbline.harness.metrics.impacts import (
    HOP,
    bounce_gain,
    bounce_height_error,
    bouncing_time_error,
    impact_time_error,
    later_restitution_error,
    restitution_error,
)
from plumbline.harness.scene import Body, Scene, Surface
from plumbline.harness.trajectory import Floats, Trajectory

MASS, SPACING = 1.0, 1.0


class P(Parameters):
    restitutions: tuple[float, ...] = (0.0, 0.3, 0.5, 0.8, 0.95, 1.0)
    drop: Positive = 1.0
    radius: Positive = 0.1


def _fall(drop: float) -> float:
    """Time to the first impact [s]."""
    return math.sqrt(2 * drop / G)


def scene(p: P) -> Scene:
    """One ball for each restitution, side by side along y, its lowest point `drop` [m] over the ground."""
    materials = [f"ball_{i}" for i in range(len(p.restitutions))]
    balls = [
        Body.ball(
            f"ball_{i}", p.radius, mass=MASS, material=materials[i], p_WB=(0.0, (SPACING + 2 * p.radius) * i, p.radius + p.drop)
        )
        for i in range(len(p.restitutions))
    ]
    return Scene(
        bodies=(Body.ground(), *balls),
        surfaces=tuple(Surface(between=(m, "ground"), restitution=e) for m, e in zip(materials, p.restitutions, strict=True)),
        apart=tuple((a, b) for i, a in enumerate(materials) for b in materials[i + 1 :]),
    )


def _bounce(time: Floats, restitution: float, drop: float) -> tuple[Floats, Floats]:
    """Height over contact [m] and speed upwards [m/s] of one ball, each (t,)."""
    fall = _fall(drop)
    gap, speed = drop - G * time**2 / 2, -G * time
    landing, up = fall, restitution * G * fall
    # A flight shorter than a picosecond is rest: what remains of a bouncing that ends in finite time.
    while landing <= time[-1] and 2 * up / G > 1e-12:
        since = time - landing
        gap = np.where(since >= 0, up * since - G * since**2 / 2, gap)
        speed = np.where(since >= 0, up - G * since, speed)
        landing, up = landing + 2 * up / G, restitution * up
    resting = time >= landing
    return np.where(resting, 0.0, gap), np.where(resting, 0.0, speed)


def expected(time: Floats, p: P) -> Trajectory:
    """The closed form: parabola after parabola, then rest."""
    truth = Trajectory.at_rest(scene(p), time)
    for i, e in enumerate(p.restitutions, start=1):
        gap, truth.v_WB[:, i, 2] = _bounce(truth.time, e, p.drop)
        truth.p_WB[:, i, 2] = gap + p.radius
    return truth


SAMPLE, DURATION = 1 / 960, 4.5


def _height(dt: float, p: P) -> float:
    """One step's way off the ground, 2 dt/t0, and gravity during the impact: 2 dt/t0 of one step's, T/(3 t0) of a spring's."""
    return (2 + max(2, SPRING_STEPS / 3)) * dt / _fall(p.drop)


def _end(dt: float, p: P) -> float:
    """The bound [s] on the end of bouncing, of the largest restitution that ends within the run; a sample where none does."""
    resting = [e for e in p.restitutions if 0 < e < 1 and _fall(p.drop) * (1 + e) / (1 - e) < DURATION]
    if not resting:
        return SAMPLE
    slowest = max(resting)
    impacts = math.log(math.sqrt(HOP)) / math.log(slowest)
    return max(2 * (1 + 1 / slowest) / (1 - slowest), SPRING_STEPS) * dt * impacts + SAMPLE


HEIGHT = (
    "a ball turned up to one step's way v dt off the ground rises as much too far or too little, v dt/h = 2 dt/t0; gravity "
    "within the impact changes its speed by up to g dt where that takes one step, 2 e^2 g dt/v = 2 dt/t0 at e = 1, and "
    "lowers the rebound of a spring that takes T = 10 dt by T/(3 t0)"
)

CASE = Case.of(
    globals(),
    title="Bouncing balls",
    question="Does a ball come back with the restitution asked for, on time, until it rests, and never higher than before?",
    source="Stronge, Impact Mechanics, 2nd ed.",
    truth="closed form",
    # Short hops need three samples to be seen.
    sample_interval=SAMPLE,
    checks=(
        Check(bounce_height_error, _height, f"{HEIGHT}; t0 is the time of fall"),
        Check(
            impact_time_error,
            lambda dt, p: (0.5 + 1 / min([e for e in p.restitutions if e > 0], default=1.0) + max(1 + 2, SPRING_STEPS)) * dt,
            "a staggered fall lands half a step early; a ball turned v dt off the ground lands v dt/(e v) off, 3.4 dt "
            "at e = 0.3, the least that flies twice; and the impact takes its time: a step, after which a speed g dt off "
            "makes 2 dt, or the ten steps of a spring, which a slower rebound only shortens",
        ),
        Check(
            bouncing_time_error,
            _end,
            "a speed after an impact that is g dt off moves the end of all bouncing by 2 dt/(1 - e); a ball turned v "
            "dt off the ground comes in g dt/e faster the next time, 2 dt/(e (1 - e)) more; a spring's impact takes ten steps; "
            "and so does each impact of the ball that takes longest to rest, n = ln(0.01)/ln(e) of them until its hops are "
            "1e-4 of the drop high; one sample beside it. A threshold under which nothing bounces ends it early",
        ),
        Check(
            bounce_gain,
            _height,
            f"what one bounce may rise too high it may gain, and no more: {HEIGHT}. That it must not gain at all is "
            "the law; a method of first order errs to either side of it, and gains anew with each bounce",
        ),
        forces_keep_momentum(),
    ),
    observe=(restitution_error, later_restitution_error),
    converges="once",
)
