"""Bias of inertial noise: the mean of its beginning against the constant of its law, in standard deviations of that mean.

A random walk soon hides a constant, so the mean is taken over as many first samples as make its variance smallest:
sigma^2/n for white noise, the sum of memory^|i-j| for a Markov process, K^2 dt (n+1)(2n+1)/(6n) for a walk from zero.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.inertial_residual import inertial_residual
from plumbline.harness.scene import AxisNoise, Imu
from plumbline.harness.trajectory import Floats

MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a Gauss-Markov process over its standard deviation (IEEE Std 952, annex C)."""


def variance_of_mean(law: AxisNoise, count: Floats, interval: float) -> Floats:
    """Variance of the mean of the first `count` samples, for each count, in the unit squared."""
    n = np.asarray(count, dtype=np.float64)
    memory = np.exp(-interval / law.instability_time)
    markov = (n * (1 - memory**2) - 2 * memory * (1 - memory**n)) / (1 - memory) ** 2 / n**2
    walk = interval * (n + 1) * (2 * n + 1) / (6 * n)
    white = law.density**2 / interval / n
    variance: Floats = white + (law.instability / MARKOV_PEAK) ** 2 * markov + law.random_walk**2 * walk
    return variance


@metric("1", empty="no inertial sensor of the scene has noise")
def inertial_bias_score(run: Run) -> list[float]:
    """definition: |mean - bias| over its standard deviation"""
    scores = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        for channel in ("accelerometer", "gyroscope"):
            law: AxisNoise = getattr(sensor.noise, channel)
            name = f"{sensor.name}/{channel}"
            noise = inertial_residual(sensor, channel, run.actual)
            if len(noise) == 0:
                raise NotMeasurable(f"stream '{name}' has no reading")
            variances = variance_of_mean(law, np.arange(1.0, len(noise) + 1.0), 1.0 / sensor.rate)
            count = int(np.argmin(variances)) + 1
            # A law without randomness leaves the rounding of the signal, which enters when noise and signal are parted again.
            rounding = 4 * np.finfo(np.float64).eps * (1 + np.abs(run.actual.streams[name]).max())
            scores.append(np.abs(noise[:count].mean(axis=0) - law.bias) / (np.sqrt(variances[count - 1]) + rounding))
    return scores
