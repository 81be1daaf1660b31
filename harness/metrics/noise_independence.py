"""Independence of inertial noise: the largest correlation between any two axes, channels and sensors, as a normal score.

Correlations are those of the samples' differences, which are stationary whatever walks. Differences of white noise have
the autocorrelation -1/2 at lag 1, which makes the variance of a correlation of two independent ones (1 + 2/4)/n (Bartlett).
Samples are compared by the number of their draw, over the length that both have: all pairs of axes of one rate.
"""

import itertools

import numpy as np

from plumbline.harness.metric import Run, metric
from plumbline.harness.metric.inertial_residual import inertial_residual
from plumbline.harness.scene import Imu
from plumbline.harness.trajectory import Floats

SOURCE = "Bartlett, Some aspects of the time-correlation problem (1935)"


@metric("1", SOURCE, empty="fewer than two noisy axes of one rate with at least 31 samples")
def inertial_correlation_score(run: Run) -> list[float]:
    columns: list[tuple[float, Floats]] = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        for channel in ("accelerometer", "gyroscope"):
            law = getattr(sensor.noise, channel)
            noise = inertial_residual(sensor, channel, run.actual)
            if law.density > 0 or law.instability > 0 or law.random_walk > 0:
                columns.extend((sensor.rate, column) for column in np.diff(noise, axis=0).T)
    scores = []
    for (rate_a, a), (rate_b, b) in itertools.combinations(columns, 2):
        # Generators that share a seed agree draw by draw, whenever the readings come: a late sensor has fewer of them.
        count = min(len(a), len(b))
        if rate_a == rate_b and count >= 30:
            scores.append(abs(np.corrcoef(a[:count], b[:count])[0, 1]) * np.sqrt(count / 1.5))
    return scores
