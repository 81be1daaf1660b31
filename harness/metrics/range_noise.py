"""Range noise against its law: mean, standard deviation, distribution and independence of the deviations, as normal scores.

A deviation is (range - ideal range) over the standard deviation that the law gives for that range: a standard normal variable,
independent from beam to beam and scan to scan. Each score is of the order of 1 where the law holds.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import maximum
from harness.scene import Lidar, Scene
from harness.trajectory import Floats, Trajectory


def _deviations(scene: Scene, actual: Trajectory) -> list[Floats]:
    """Of each noisy range finder, (scans, channels, columns); infinite for beams without a return."""
    deviations = []
    for sensor in scene.sensors:
        if not isinstance(sensor, Lidar) or sensor.noise is None:
            continue
        if sensor.noise.range_sigma == 0 and sensor.noise.range_sigma_slope == 0:
            continue
        noisy, ideal = (actual.streams.get(f"{sensor.name}/{channel}") for channel in ("range", "range_ideal"))
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


def _flat(scene: Scene, actual: Trajectory) -> Floats:
    """The deviations of all beams that returned, (n,)."""
    deviations = np.concatenate([d[~np.isinf(d)] for d in _deviations(scene, actual)])
    if len(deviations) < 100:
        raise NotMeasurable(f"{len(deviations)} beams returned, at least 100 are needed for statistics")
    return deviations


def _mean(scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    deviations = _flat(scene, actual)
    return float(abs(deviations.mean()) * np.sqrt(len(deviations)))


def _spread(scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    """Wilson and Hilferty's cube root makes the chi-squared sum of squares normal to one part in n."""
    deviations = _flat(scene, actual)
    n = len(deviations)
    third = 2.0 / (9.0 * n)
    return float(abs((np.sum(np.square(deviations)) / n) ** (1 / 3) - (1 - third)) / np.sqrt(third))


def _distribution(scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    """Kolmogorov's distance from the standard normal distribution times sqrt(n)."""
    from scipy import stats  # late: a listing must not pay for it

    deviations = _flat(scene, actual)
    if np.isnan(deviations).any():
        return float("nan")
    # The statistic is the same by any method; this one spends nothing on the p-value, which takes most of the time otherwise.
    return float(stats.kstest(deviations, "norm", method="asymp").statistic * np.sqrt(len(deviations)))


def _correlation(scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    """Largest over neighbours in time, elevation and azimuth: the mean product of deviations is 1/sqrt(n) wide."""
    scores = []
    for deviation in _deviations(scene, actual):
        for axis in range(3):
            count = deviation.shape[axis]
            a, b = (deviation.take(np.arange(start, count - 1 + start), axis=axis).ravel() for start in (0, 1))
            both = ~np.isinf(a) & ~np.isinf(b)
            if both.sum() >= 100:
                scores.append(abs(np.mean(a[both] * b[both])) * np.sqrt(both.sum()))
    if not scores:
        raise NotMeasurable("fewer than 100 pairs of neighbouring beams returned")
    return maximum(np.array(scores))


RANGE_MEAN = Metric(name="range_mean_score", unit="1", source="standard error of a mean", measure=_mean)
RANGE_SPREAD = Metric(name="range_spread_score", unit="1", source="Wilson, Hilferty (1931): chi^2 of squares", measure=_spread)
RANGE_DISTRIBUTION = Metric(
    name="range_distribution_distance", unit="1", source="Kolmogorov (1933): sqrt(n) D", measure=_distribution
)
RANGE_CORRELATION = Metric(
    name="range_correlation_score", unit="1", source="correlation of neighbouring beams and scans", measure=_correlation
)

METRIC = (RANGE_MEAN, RANGE_SPREAD, RANGE_DISTRIBUTION, RANGE_CORRELATION)
