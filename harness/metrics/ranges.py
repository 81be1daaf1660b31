"""Ranges of range finders: ideal ones against closed form, and noisy ones against the law of their noise.

Of ideal ranges the errors of the beams that both hit, and the share on which they disagree. The truth carries
'<sensor>/range_ideal' for the same scans. A hit against no hit is a false return; so is a hit on another surface, taken to be
one when the range differs by more than a tenth of it.

Of noise the mean, standard deviation, distribution and independence of the deviations, as normal scores. A deviation is
(range - ideal range) over the standard deviation that the law gives for that range: a standard normal variable, independent
from beam to beam and scan to scan. Each score is of the order of 1 where the law holds. The rate of dropouts is scored by its
distance from the law in the standard deviations that the law gives it: below z it says that Wilson's interval for confidence z,
drawn about the observed rate, holds the law's rate.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.noise_scores import kolmogorov_distance, mean_score, neighbour_scores, share_score, spread_score
from plumbline.harness.metric.series import root_mean_square
from plumbline.harness.scene import Lidar, LidarNoise
from plumbline.harness.trajectory import Floats

SOURCE = "closed-form intersection of rays and primitives"
OTHER_SURFACE = 0.1
RAYS = "rays"
"""The stream of a case that casts rays of its own, without a sensor."""


def _pairs(run: Run, channel: str) -> tuple[Floats, Floats]:
    """The stream of all range finders, and of the case's own rays, and its truth, as two flat arrays."""
    finders = [sensor.name for sensor in run.scene.sensors if isinstance(sensor, Lidar)]
    if run.expected is not None and f"{RAYS}/time" in run.expected.streams:
        finders.append(RAYS)
    if not finders:
        raise NotMeasurable("the scene has no range finder")
    readings, truths = zip(*(run.beside_truth(finder, channel) for finder in finders), strict=True)
    return np.concatenate([a.ravel() for a in readings]), np.concatenate([a.ravel() for a in truths])


def _same_surface(readings: Floats, truth: Floats) -> NDArray[np.bool_]:
    """Mask of beams that hit what the truth hits; NaN counts as a hit, so that it shows in the error."""
    hit = ~np.isinf(readings) & ~np.isinf(truth)
    with np.errstate(invalid="ignore"):
        mask: NDArray[np.bool_] = hit & ~(np.abs(readings - truth) > OTHER_SURFACE * truth)
    return mask


def _errors(run: Run) -> Floats:
    readings, truth = _pairs(run, "range_ideal")
    same = _same_surface(readings, truth)
    if not same.any():
        raise NotMeasurable("no beam meets the surface that the truth meets")
    error: Floats = np.abs(readings[same] - truth[same])
    return error


@metric("1", SOURCE)
def range_false_return_share(run: Run) -> float:
    readings, truth = _pairs(run, "range_ideal")
    if np.isnan(readings).any():
        return float("nan")
    return float(np.mean(~_same_surface(readings, truth) & ~(np.isinf(readings) & np.isinf(truth))))


@metric("1")
def intensity_error_max(run: Run) -> Floats:
    """Lambert's cosine law"""
    readings, truth = _pairs(run, "intensity_ideal")
    same = _same_surface(*_pairs(run, "range_ideal"))
    if not same.any() or np.isnan(readings[same]).all():
        raise NotMeasurable("the engine gives no normals where its rays hit")
    return np.abs(readings[same] - truth[same])


@metric("m", SOURCE)
def range_error_max(run: Run) -> Floats:
    return _errors(run)


@metric("m", SOURCE)
def range_error_rms(run: Run) -> float:
    return root_mean_square(_errors(run))


@metric("m", SOURCE)
def range_error_median(run: Run) -> float:
    return float(np.median(_errors(run)))


def _noisy(run: Run) -> Iterator[tuple[LidarNoise, Floats, Floats]]:
    """Of each range finder that has noise: its law, the ranges that it reads and the ideal ones."""
    for sensor in run.scene.sensors:
        if isinstance(sensor, Lidar) and sensor.noise is not None:
            yield sensor.noise, run.stream(f"{sensor.name}/range"), run.stream(f"{sensor.name}/range_ideal")


def _deviations(run: Run) -> list[Floats]:
    """Of each noisy range finder, (scans, channels, columns); infinite for beams without a return."""
    deviations = []
    for law, noisy, ideal in _noisy(run):
        if law.range_sigma > 0 or law.range_sigma_slope > 0:
            sigma = law.range_sigma + law.range_sigma_slope * ideal
            heard = ~np.isinf(noisy) & ~np.isinf(ideal)
            deviations.append(np.full(noisy.shape, np.inf))
            deviations[-1][heard] = (noisy[heard] - ideal[heard]) / sigma[heard]
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


@metric("1", empty="no range finder of the scene has a noise model")
def dropout_score(run: Run) -> list[float]:
    """Wilson, Probable inference, the law of succession, and statistical inference (1927)"""
    scores = []
    for law, noisy, ideal in _noisy(run):
        if np.isnan(noisy).any() or np.isnan(ideal).any():
            return [float("nan")]
        hit = np.isfinite(ideal)
        if not hit.any():
            raise NotMeasurable("no beam hits anything")
        # A return from nothing is no dropout, and no law allows it.
        if np.isfinite(noisy[~hit]).any():
            return [float("inf")]
        scores.append(share_score(float(np.mean(~np.isfinite(noisy[hit]))), law.dropout, int(hit.sum())))
    return scores
