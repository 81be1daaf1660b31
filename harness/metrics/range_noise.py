"""Range noise against its law: mean, standard deviation, distribution and independence of the deviations, as normal scores.

A deviation is (range - ideal range) over the standard deviation that the law gives for that range: a standard normal variable,
independent from beam to beam and scan to scan. Each score is of the order of 1 where the law holds.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Lidar
from plumbline.harness.trajectory import Floats


def _deviations(run: Run) -> list[Floats]:
    """Of each noisy range finder, (scans, channels, columns); infinite for beams without a return."""
    deviations = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Lidar) or sensor.noise is None:
            continue
        if sensor.noise.range_sigma == 0 and sensor.noise.range_sigma_slope == 0:
            continue
        noisy, ideal = (run.actual.streams.get(f"{sensor.name}/{channel}") for channel in ("range", "range_ideal"))
        if noisy is None or ideal is None:
            raise NotMeasurable(f"ranges of sensor '{sensor.name}' were not recorded")
        sigma = sensor.noise.range_sigma + sensor.noise.range_sigma_slope * ideal
        heard = ~np.isinf(noisy) & ~np.isinf(ideal)
        deviation = np.full(noisy.shape, np.inf)
        deviation[heard] = (noisy[heard] - ideal[heard]) / sigma[heard]
        deviations.append(deviation)
    if not deviations:
        raise NotMeasurable("no range finder of the scene has range noise")
    return deviations


def _flat(run: Run) -> Floats:
    """The deviations of all beams that returned, (n,)."""
    deviations = np.concatenate([d[~np.isinf(d)] for d in _deviations(run)])
    if len(deviations) < 100:
        raise NotMeasurable(f"{len(deviations)} beams returned, at least 100 are needed for statistics")
    return deviations


@metric("1")
def range_mean_score(run: Run) -> float:
    """standard error of a mean"""
    deviations = _flat(run)
    return float(abs(deviations.mean()) * np.sqrt(len(deviations)))


@metric("1")
def range_spread_score(run: Run) -> float:
    """Wilson, Hilferty (1931): chi^2 of squares"""
    # Wilson and Hilferty's cube root makes the chi-squared sum of squares normal to one part in n.
    deviations = _flat(run)
    n = len(deviations)
    third = 2.0 / (9.0 * n)
    return float(abs((np.sum(np.square(deviations)) / n) ** (1 / 3) - (1 - third)) / np.sqrt(third))


@metric("1")
def range_distribution_distance(run: Run) -> float:
    """Kolmogorov (1933): sqrt(n) D"""
    # Kolmogorov's distance from the standard normal distribution times sqrt(n).
    from scipy import stats  # late: a listing must not pay for it

    deviations = _flat(run)
    if np.isnan(deviations).any():
        return float("nan")
    # The statistic is the same by any method; this one spends nothing on the p-value, which takes most of the time otherwise.
    return float(stats.kstest(deviations, "norm", method="asymp").statistic * np.sqrt(len(deviations)))


@metric("1", empty="fewer than 100 pairs of neighbouring beams returned")
def range_correlation_score(run: Run) -> list[float]:
    """correlation of neighbouring beams and scans"""
    # Largest over neighbours in time, elevation and azimuth: the mean product of deviations is 1/sqrt(n) wide.
    scores = []
    for deviation in _deviations(run):
        for axis in range(3):
            count = deviation.shape[axis]
            a, b = (deviation.take(np.arange(start, count - 1 + start), axis=axis).ravel() for start in (0, 1))
            both = ~np.isinf(a) & ~np.isinf(b)
            if both.sum() >= 100:
                scores.append(abs(np.mean(a[both] * b[both])) * np.sqrt(both.sum()))
    return scores
