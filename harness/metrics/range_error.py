"""Ideal ranges of a range finder against closed form: errors of the beams that both hit, and the share on which they disagree.

The truth carries '<sensor>/range_ideal' for the same scans. A hit against no hit is a false return; so is a hit on another
surface, taken to be one when the range differs by more than a tenth of it.
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import root_mean_square
from plumbline.harness.scene import Lidar, Scene
from plumbline.harness.trajectory import Floats, Trajectory

SOURCE = "closed-form intersection of rays and primitives"
OTHER_SURFACE = 0.1
RAYS = "rays"
"""The stream of a case that casts rays of its own, without a sensor."""


def _pairs(scene: Scene, actual: Trajectory, expected: Trajectory | None, channel: str) -> tuple[Floats, Floats]:
    """The stream of all range finders, and of the case's own rays, and its truth, as two flat arrays."""
    readings: list[Floats] = []
    truths: list[Floats] = []
    finders = [sensor.name for sensor in scene.sensors if isinstance(sensor, Lidar)]
    if expected is not None and f"{RAYS}/time" in expected.streams:
        finders.append(RAYS)
    for finder in finders:
        name, stamps = f"{finder}/{channel}", f"{finder}/time"
        if expected is None or name not in expected.streams:
            raise NotMeasurable(f"the truth has no stream '{name}'")
        if name not in actual.streams:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        here, there = actual.streams[stamps], expected.streams[stamps]
        if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
            raise NotMeasurable(f"the truth of '{name}' stands at other times than the scans")
        readings.append(actual.streams[name].ravel())
        truths.append(expected.streams[name].ravel())
    if not readings or sum(map(len, readings)) == 0:
        raise NotMeasurable("the scene has no range finder, or it made no scan")
    return np.concatenate(readings), np.concatenate(truths)


def _same_surface(readings: Floats, truth: Floats) -> NDArray[np.bool_]:
    """Mask of beams that hit what the truth hits; NaN counts as a hit, so that it shows in the error."""
    hit = ~np.isinf(readings) & ~np.isinf(truth)
    with np.errstate(invalid="ignore"):
        mask: NDArray[np.bool_] = hit & ~(np.abs(readings - truth) > OTHER_SURFACE * truth)
    return mask


def _errors(run: Run) -> Floats:
    readings, truth = _pairs(run.scene, run.actual, run.expected, "range_ideal")
    same = _same_surface(readings, truth)
    if not same.any():
        raise NotMeasurable("no beam meets the surface that the truth meets")
    error: Floats = np.abs(readings[same] - truth[same])
    return error


@metric("1", SOURCE)
def range_false_return_share(run: Run) -> float:
    readings, truth = _pairs(run.scene, run.actual, run.expected, "range_ideal")
    if np.isnan(readings).any():
        return float("nan")
    return float(np.mean(~_same_surface(readings, truth) & ~(np.isinf(readings) & np.isinf(truth))))


@metric("1")
def intensity_error_max(run: Run) -> Floats:
    """Lambert's cosine law"""
    readings, truth = _pairs(run.scene, run.actual, run.expected, "intensity_ideal")
    ranges, true_ranges = _pairs(run.scene, run.actual, run.expected, "range_ideal")
    same = _same_surface(ranges, true_ranges)
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
