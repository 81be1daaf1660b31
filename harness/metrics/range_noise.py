"""Range noise against its law: mean, standard deviation, distribution and independence of the deviations, as normal scores.

A deviation is (range - ideal range) over the standard deviation that the law gives for that range: a standard normal variable,
independent from beam to beam and scan to scan. Each score is of the order of 1 where the law holds.

Dropout rate: its distance from the law in the standard deviations that the law gives it.

A score below z says that Wilson's interval for confidence z, drawn about the observed rate, holds the law's rate.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.noise_scores import kolmogorov_distance, mean_score, neighbour_scores, share_score, spread_score
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
    return mean_score(_flat(run))


@metric("1")
def range_spread_score(run: Run) -> float:
    """Wilson, Hilferty (1931): chi^2 of squares"""
    return spread_score(_flat(run))


@metric("1")
def range_distribution_distance(run: Run) -> float:
    """Kolmogorov (1933): sqrt(n) D"""
    return kolmogorov_distance(_flat(run))


@metric("1", empty="fewer than 100 pairs of neighbouring beams returned")
def range_correlation_score(run: Run) -> list[float]:
    """correlation of neighbouring beams and scans"""
    # Neighbours in time, elevation and azimuth.
    return [score for deviation in _deviations(run) for score in neighbour_scores(deviation, 100)]


SOURCE = "Wilson, Probable inference, the law of succession, and statistical inference (1927)"


@metric("1", SOURCE)
def dropout_score(run: Run) -> float:
    scores = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Lidar) or sensor.noise is None:
            continue
        noisy, ideal = (run.actual.streams.get(f"{sensor.name}/{channel}") for channel in ("range", "range_ideal"))
        if noisy is None or ideal is None:
            raise NotMeasurable(f"ranges of sensor '{sensor.name}' were not recorded")
        if np.isnan(noisy).any() or np.isnan(ideal).any():
            return float("nan")
        hit = np.isfinite(ideal)
        count, law = int(hit.sum()), sensor.noise.dropout
        if count == 0:
            raise NotMeasurable(f"no beam of sensor '{sensor.name}' hits anything")
        if np.isfinite(noisy[~hit]).any():
            # A return from nothing is no dropout, and no law allows it.
            return float("inf")
        lost = float(np.mean(~np.isfinite(noisy[hit])))
        scores.append(share_score(lost, law, count))
    if not scores:
        raise NotMeasurable("no range finder of the scene has a noise model")
    return float(np.max(scores))
