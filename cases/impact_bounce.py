"""Balls of different restitution dropped on level ground: how high do they come back?

A ball dropped from h meets the ground at t0 = sqrt(2 h/g) and rises to e^2 h, e^4 h, ...; impact n comes at
t0 (1 + 2 (e + ... + e^n)), and all bouncing ends at t0 (1 + e)/(1 - e).
Source: Stronge, Impact Mechanics, 2nd ed.; Falcon et al., Eur. Phys. J. B 3 (1998) 45.
"""

import math
from collections.abc import Sequence

import numpy as np

from harness.case import Case, Check
from harness.checks.contact_laws import forces_keep_momentum
from harness.metrics.restitution import (
    APEX_GAIN,
    BOUNCE_HEIGHT_ERROR,
    BOUNCING_TIME_ERROR,
    HOP,
    IMPACT_TIME_ERROR,
    LATER_RESTITUTION_ERROR,
    RESTITUTION_ERROR,
)
from harness.scene import EARTH_GRAVITY, Body, PlacedShape, Plane, Scene, Sphere, Surface, sphere_inertia
from harness.trajectory import Floats, Trajectory

G = -EARTH_GRAVITY[2]
RESTITUTIONS = (0.0, 0.3, 0.5, 0.8, 0.95, 1.0)
DROP, RADIUS, MASS, SPACING = 1.0, 0.1, 1.0, 1.0


def _fall(drop: float = DROP) -> float:
    """Time to the first impact [s]."""
    return math.sqrt(2 * drop / G)


def scene(restitutions: Sequence[float] = RESTITUTIONS, drop: float = DROP, radius: float = RADIUS) -> Scene:
    """One ball for each restitution, side by side along y, its lowest point `drop` [m] over the ground."""
    materials = [f"ball_{i}" for i in range(len(restitutions))]
    balls = [
        Body(
            name=f"ball_{i}",
            mass=MASS,
            inertia=sphere_inertia(MASS, radius),
            collision=(PlacedShape(shape=Sphere(radius=radius)),),
            material=materials[i],
            p_WB=(0.0, (SPACING + 2 * radius) * i, radius + drop),
        )
        for i in range(len(restitutions))
    ]
    ground = Body(name="ground", motion="static", material="ground", collision=(PlacedShape(shape=Plane()),))
    return Scene(
        bodies=(ground, *balls),
        surfaces=tuple(Surface(between=(m, "ground"), restitution=e) for m, e in zip(materials, restitutions, strict=True)),
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


def expected(
    time: Floats, restitutions: Sequence[float] = RESTITUTIONS, drop: float = DROP, radius: float = RADIUS
) -> Trajectory:
    """The closed form: parabola after parabola, then rest."""
    truth = Trajectory.of(time, 1 + len(restitutions))
    for i, e in enumerate(restitutions, start=1):
        truth.p_WB[:, i, 1] = (SPACING + 2 * radius) * (i - 1)
        gap, truth.v_WB[:, i, 2] = _bounce(truth.time, e, drop)
        truth.p_WB[:, i, 2] = gap + radius
    return truth


SAMPLE, DURATION = 1 / 960, 4.5


def _end(dt: float, restitutions: Sequence[float] = RESTITUTIONS, drop: float = DROP) -> float:
    """The bound [s] on the end of bouncing, of the largest restitution that ends within the run; a sample where none does."""
    resting = [e for e in restitutions if 0 < e < 1 and _fall(drop) * (1 + e) / (1 - e) < DURATION]
    if not resting:
        return SAMPLE
    slowest = max(resting)
    return 2 * dt / (1 - slowest) * math.log(math.sqrt(HOP)) / math.log(slowest) + SAMPLE


CASE = Case(
    name="impact_bounce",
    title="Bouncing balls",
    question="Does a ball come back with the restitution asked for, on time, until it rests, and never with more energy?",
    source="Stronge, Impact Mechanics, 2nd ed.",
    truth="closed form",
    scene=scene,
    expected=expected,
    parameters={"restitutions": RESTITUTIONS, "drop": DROP, "radius": RADIUS},
    duration=DURATION,
    # Short hops need three samples to be seen.
    sample_interval=SAMPLE,
    with_contacts=True,
    checks=(
        Check(
            metric=BOUNCE_HEIGHT_ERROR,
            at_most=lambda dt, drop=DROP: 4 * dt / _fall(drop),
            because="a ball turned up to one step's way v dt off the ground rises as much too far or too little, v dt/h = 2 "
            "dt/t0, and gravity within the step of the impact changes its speed by up to g dt, 2 e^2 g dt/v = 2 dt/t0 at e = "
            "1; t0 is the time of fall",
        ),
        Check(
            metric=IMPACT_TIME_ERROR,
            at_most=lambda dt: 7 * dt,
            because="a staggered fall lands half a step early and the impact takes its step, 1.5 dt; a ball turned v dt off "
            "the ground lands v dt/(e v) off, 3.4 dt at e = 0.3, the least that flies twice; a speed g dt off makes 2 dt",
        ),
        Check(
            metric=BOUNCING_TIME_ERROR,
            at_most=_end,
            because="a speed after an impact that is g dt off moves the end of all bouncing by 2 dt/(1 - e), and so does each "
            "impact of the ball that takes longest to rest, n = ln(0.01)/ln(e) of them until its hops are 1e-4 of the drop "
            "high; one sample beside it. A threshold under which nothing bounces ends it early",
        ),
        Check(
            metric=APEX_GAIN,
            at_most=lambda dt, drop=DROP: G * dt**2 / (8 * drop) + 1e-9,
            because="energy never grows at an impact; a semi-implicit fall lies on a parabola whose apex, half a step before "
            "the start, is g dt^2/8 higher; 1e-9 for rounding",
        ),
        forces_keep_momentum(),
    ),
    observe=(RESTITUTION_ERROR, LATER_RESTITUTION_ERROR),
    headline="bounce_height_error",
    converges="once",
)
