"""Jitter: what still moves where everything should rest."""

import math
from collections.abc import Callable

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory


def _worst(law: Callable[[Trajectory, list[int]], Floats], samples: int) -> Callable[..., float]:
    """A measure that takes the worst of a law's values, one a movable body."""

    def measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
        movable = [place for place, body in enumerate(scene.bodies) if body.movable]
        if not movable or len(actual) < samples:
            raise NotMeasurable(f"{len(movable)} movable bodies and {len(actual)} samples, expected at least 1 and {samples}")
        return float(np.max(law(actual, movable))) if actual.finite else math.nan

    return measure


def _root_mean_square(vectors: Floats) -> Floats:
    """Over time: (t, n, 3) to (n,)."""
    rms: Floats = np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=0))
    return rms


def _speed(run: Trajectory, movable: list[int]) -> Floats:
    return _root_mean_square(run.v_WB[:, movable])


def _spin(run: Trajectory, movable: list[int]) -> Floats:
    return _root_mean_square(run.w_WB[:, movable])


def _second_difference(run: Trajectory, movable: list[int]) -> Floats:
    spacing = np.diff(run.time)
    if run.dt > 0 and np.any(np.abs(spacing - run.dt) > 1e-6 * run.dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {run.dt:g} s")
    return _root_mean_square(np.diff(run.p_WB[:, movable], n=2, axis=0))


def _height(run: Trajectory, movable: list[int]) -> Floats:
    span: Floats = np.ptp(np.percentile(run.p_WB[:, movable, 2], [1, 99], axis=0), axis=0)
    return span


def _drift(run: Trajectory, movable: list[int]) -> Floats:
    drift: Floats = np.linalg.norm(run.p_WB[-1, movable] - run.p_WB[0, movable], axis=1)
    return drift


RMS_SPEED = Metric(
    name="rms_speed", unit="m/s", source="root mean square of |v_WB| over the window, worst body", measure=_worst(_speed, 1)
)
RMS_SPIN = Metric(
    name="rms_spin", unit="rad/s", source="root mean square of |w_WB| over the window, worst body", measure=_worst(_spin, 1)
)
RMS_SECOND_DIFFERENCE = Metric(
    name="rms_second_difference",
    unit="m",
    source="root mean square of |p(t+dt) - 2 p(t) + p(t-dt)| over the window, worst body; dt^2 times an accelerometer's noise",
    measure=_worst(_second_difference, 3),
)
HEIGHT_SPREAD = Metric(
    name="height_spread",
    unit="m",
    source="99th less 1st percentile of the height over the window, worst body",
    measure=_worst(_height, 2),
)
REST_DRIFT = Metric(
    name="rest_drift", unit="m", source="way from the window's start to its end, worst body", measure=_worst(_drift, 2)
)

METRIC = (RMS_SPEED, RMS_SPIN, RMS_SECOND_DIFFERENCE, HEIGHT_SPREAD, REST_DRIFT)
