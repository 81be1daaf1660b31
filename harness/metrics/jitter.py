"""Jitter: what still moves where everything should rest."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory import Floats, Integers


def _movable(run: Run, samples: int) -> Integers:
    """The movable bodies. Raises: NotMeasurable, without any or with fewer samples than these."""
    if not len(run.movable) or len(run.actual) < samples:
        raise NotMeasurable(
            f"{len(run.movable)} movable bodies and {len(run.actual)} samples, expected at least 1 and {samples}"
        )
    return run.movable


def _root_mean_square(vectors: Floats) -> Floats:
    """Over time: (t, n, 3) to (n,)."""
    rms: Floats = np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=0))
    return rms


@metric("m/s")
def rms_speed(run: Run) -> Floats:
    """root mean square of |v_WB| over the window, worst body"""
    return _root_mean_square(run.actual.v_WB[:, _movable(run, 1)])


@metric("rad/s")
def rms_spin(run: Run) -> Floats:
    """root mean square of |w_WB| over the window, worst body"""
    return _root_mean_square(run.actual.w_WB[:, _movable(run, 1)])


@metric("m")
def rms_second_difference(run: Run) -> Floats:
    """root mean square of |p(t+dt) - 2 p(t) + p(t-dt)| over the window, worst body; dt^2 times an accelerometer's noise"""
    bodies, dt, spacing = _movable(run, 3), run.actual.dt, np.diff(run.actual.time)
    if dt > 0 and np.any(np.abs(spacing - dt) > 1e-6 * dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {dt:g} s")
    return _root_mean_square(np.diff(run.actual.p_WB[:, bodies], n=2, axis=0))


@metric("m")
def height_spread(run: Run) -> Floats:
    """99th less 1st percentile of the height over the window, worst body"""
    span: Floats = np.ptp(np.percentile(run.actual.p_WB[:, _movable(run, 2), 2], [1, 99], axis=0), axis=0)
    return span


@metric("m")
def rest_drift(run: Run) -> Floats:
    """way from the window's start to its end, worst body"""
    bodies = _movable(run, 2)
    drift: Floats = np.linalg.norm(run.actual.p_WB[-1, bodies] - run.actual.p_WB[0, bodies], axis=1)
    return drift
