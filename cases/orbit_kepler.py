"""A planet on an ellipse, drawn to the origin by a force that is told anew before each step: does the orbit stay closed?

Forces that users apply themselves are held over a step. With these the best that an engine can do is a drift, a kick and
a drift: it keeps the size and the shape of the orbit for ever and errs in phase only, in proportion to dt^2 and to time.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Annotated

import numpy as np
from annotated_types import Interval

from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.case.forces import Control
from plumbline.harness.metric import Metric
from plumbline.harness.metrics import errors, periods
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Floats, State, Trajectory

PERIODS = 100
AXIS, PERIOD_TIME, MASS, RADIUS = 1.0, 1.0, 1.0, 0.05
"""Half the long axis [m] and the time of a revolution [s]: the strength of the centre is 4 pi^2 m3/s2."""
STRENGTH = 4 * np.pi**2 * AXIS**3 / PERIOD_TIME**2
RATE = 2 * np.pi / PERIOD_TIME


class P(Parameters):
    eccentricity: Annotated[float, Interval(gt=0, lt=1)] = 0.5


def scene(p: P) -> Scene:
    """One body in the plane z = 0, where it is farthest from the origin: on the x axis, moving against y; no gravity."""
    speed = RATE * AXIS * float(np.sqrt((1 - p.eccentricity) / (1 + p.eccentricity)))
    planet = Body.ball(
        "planet", RADIUS, mass=MASS, touches=False, p_WB=(-AXIS * (1 + p.eccentricity), 0.0, 0.0), v_WB=(0.0, -speed, 0.0)
    )
    return Scene(bodies=(planet,), gravity=(0.0, 0.0, 0.0))


def control(_: P) -> Control:
    """-m k r/|r|^3, told in every step."""

    no_torque = np.zeros((1, 3))

    def wrench(_time: float, state: State) -> tuple[Floats, Floats]:
        distance = math.hypot(*state.p_WB[0])
        return state.p_WB * (-MASS * STRENGTH / distance**3), no_torque

    return Control(wrench=wrench)


def eccentric_anomaly(mean: Floats, eccentricity: float) -> Floats:
    """E of Kepler's equation E - e sin E = M, (t,) rad, by Newton's method.

    From pi (where the function is neither steep nor flat) it ends within ten steps for e <= 0.9; Danby, Fundamentals of
    Celestial Mechanics, 2nd ed., section 6.6.
    """
    turns = 2 * np.pi * np.floor(mean / (2 * np.pi))
    rest = mean - turns
    eccentric = np.full_like(rest, np.pi)
    for _ in range(50):
        change = (eccentric - eccentricity * np.sin(eccentric) - rest) / (1 - eccentricity * np.cos(eccentric))
        eccentric = eccentric - change
        if np.abs(change).max(initial=0.0) < 1e-15 * np.pi:
            break
    anomaly: Floats = eccentric + turns
    return anomaly


def expected(time: Floats, p: P) -> Trajectory:
    """x = a (cos E - e), y = a sqrt(1 - e^2) sin E with E - e sin E = 2 pi t/T + pi."""
    truth = Trajectory.of(time, 1)
    anomaly = eccentric_anomaly(RATE * truth.time + np.pi, p.eccentricity)
    short, turning = np.sqrt(1 - p.eccentricity**2), RATE / (1 - p.eccentricity * np.cos(anomaly))
    truth.p_WB[:, 0, 0] = AXIS * (np.cos(anomaly) - p.eccentricity)
    truth.p_WB[:, 0, 1] = AXIS * short * np.sin(anomaly)
    truth.v_WB[:, 0, 0] = -AXIS * turning * np.sin(anomaly)
    truth.v_WB[:, 0, 1] = AXIS * short * turning * np.cos(anomaly)
    return truth


def textbook(dt: float, lead: float, duration: float, every: int, p: P) -> Trajectory:
    """The orbit by steps of drift (lead dt), kick (dt), drift ((1 - lead) dt), each `every`-th kept.

    A lead of 0 is semi-implicit Euler, 1/2 is leapfrog.
    """
    steps = round(duration / dt)
    time: Floats = np.arange(0, steps + 1, every, dtype=np.float64) * dt
    run = replace(Trajectory.of(time, 1), dt=dt)
    start = scene(p).bodies[0]
    (x, y, _), (u, v, _) = start.p_WB, start.v_WB
    before, after, kick = lead * dt, (1 - lead) * dt, -STRENGTH * dt
    states = np.empty((steps + 1, 4))
    states[0] = x, y, u, v
    for k in range(1, steps + 1):
        x, y = x + before * u, y + before * v
        pull = kick / (x * x + y * y) ** 1.5
        u, v = u + pull * x, v + pull * y
        x, y = x + after * u, y + after * v
        states[k] = x, y, u, v
    run.p_WB[:, 0, :2], run.v_WB[:, 0, :2] = states[::every, :2], states[::every, 2:]
    return run


CHECKED = (periods.phase_error, periods.period_error, errors.radius_error_max, periods.orbit_energy_drift_max)


@lru_cache(maxsize=16)
def _errors(dt: float, p: P) -> dict[str, float]:
    """The larger of semi-implicit Euler's and leapfrog's own values of each metric at this step."""
    stage, worst = scene(p), dict.fromkeys((metric.name for metric in CHECKED), 0.0)
    for lead in (0.0, 0.5):
        run = textbook(dt, lead, CASE.duration, max(1, round(CASE.sample_interval / dt)), p)
        truth = expected(run.time, p)
        for metric in CHECKED:
            worst[metric.name] = max(worst[metric.name], metric(stage, run, truth))
    return worst


def _check(metric: Metric) -> Check:
    return Check(metric, lambda dt, p: 2 * _errors(dt.outer, p)[metric.name], WHY)


WHY = (
    "twice what drift, kick and drift make of this very orbit at this step, the worse of semi-implicit Euler (kick first) "
    "and leapfrog (kick midway); sub-steps lie between them. What loses or gains energy spirals beyond it within some turns"
)

CASE = Case.of(
    globals(),
    title="Kepler's ellipse",
    question="Under a central force told anew before each step, does a planet keep its ellipse for a hundred turns?",
    source="Kepler's equation (Goldstein, Classical Mechanics, 3rd ed., section 3.8); Hairer, Lubich, Wanner, Geometric "
    "Numerical Integration, 2nd ed., section I.2",
    truth="closed form",
    duration=PERIODS * PERIOD_TIME,
    ladder=(1 / 60, 1 / 90, 1 / 120, 1 / 180, 1 / 240, 1 / 480),
    checks=tuple(_check(metric) for metric in CHECKED),
    observe=(
        periods.orbit_energy_drift_staggered_max,
        periods.orbit_energy_drift_final,
        errors.radius_error_final,
        errors.position_error_max,
        errors.position_error_final,
    ),
)
