"""Distribution of inertial noise against the normal one of its law: Kolmogorov's distance, and chi-squared of a histogram.

Every second difference of samples is taken: with white noise and a random walk these are independent normal variables of the
variance 2 N^2/T + K^2 T. A Markov process would correlate them, so that a law that has one is not measured.

Source: Kolmogorov (1933), sqrt(n) D; Pearson (1900), with cells of equal probability (Mann, Wald, On the choice of the number
of class intervals, 1942) and Wilson and Hilferty's cube root, which makes a chi-squared variable normal.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.inertial_residual import inertial_residual
from plumbline.harness.scene import AxisNoise, Imu
from plumbline.harness.trajectory import Floats

CELLS = 64
FEWEST = 20 * CELLS
"""Samples below which a cell's count is no normal variable."""


def kolmogorov_distance(deviations: Floats) -> float:
    """sqrt(n) D from the standard normal distribution, of (n,); NaN where one is."""
    from scipy import stats  # late: a listing must not pay for it

    if np.isnan(deviations).any():
        return float("nan")
    # The statistic is the same by any method; this one spends nothing on the p-value, which takes most of the time otherwise.
    return float(stats.kstest(deviations, "norm", method="asymp").statistic * np.sqrt(len(deviations)))


def histogram_score(deviations: Floats) -> float:
    """Pearson's chi-squared over cells of equal probability as a normal score, of (n,); NaN where one is."""
    from scipy import stats  # late: a listing must not pay for it

    if np.isnan(deviations).any():
        return float("nan")
    edges = stats.norm.ppf(np.arange(1, CELLS) / CELLS)
    counts = np.bincount(np.searchsorted(edges, deviations), minlength=CELLS)
    mean = len(deviations) / CELLS
    freedom = CELLS - 1
    third = 2.0 / (9.0 * freedom)
    level = float(np.sum(np.square(counts - mean))) / mean / freedom
    # Counts that are more even than chance allows are as wrong as uneven ones.
    return float(abs(level ** (1 / 3) - (1 - third)) / np.sqrt(third))


def _deviations(run: Run) -> list[Floats]:
    """Of each noisy axis, (n,)."""
    deviations: list[Floats] = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        for channel in ("accelerometer", "gyroscope"):
            law: AxisNoise = getattr(sensor.noise, channel)
            variance = 2 * law.density**2 * sensor.rate + law.random_walk**2 / sensor.rate
            if variance == 0 and law.instability == 0:
                continue
            if law.instability > 0:
                raise NotMeasurable(
                    f"the {channel} of sensor '{sensor.name}' has bias instability, whose samples are correlated"
                )
            change = np.diff(inertial_residual(sensor, channel, run.actual), axis=0)[::2]
            if len(change) < FEWEST:
                raise NotMeasurable(f"stream '{sensor.name}/{channel}' has {len(change)} differences, {FEWEST} are needed")
            deviations.extend((change / np.sqrt(variance)).T)
    if not deviations:
        raise NotMeasurable("no inertial sensor of the scene has random noise")
    return deviations


@metric("1")
def inertial_distribution_distance(run: Run) -> list[float]:
    """Kolmogorov (1933): sqrt(n) D"""
    return [kolmogorov_distance(deviation) for deviation in _deviations(run)]


@metric("1")
def inertial_histogram_score(run: Run) -> list[float]:
    """Pearson (1900); Mann, Wald (1942)"""
    return [histogram_score(deviation) for deviation in _deviations(run)]
