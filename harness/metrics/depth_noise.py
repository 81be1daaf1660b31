"""Depth noise against its law: mean and spread of deviations in each band of depth, and independence, as normal scores.

A deviation is what was measured (disparity, or range up to whole wraps) less its ideal value, over the standard deviation that
the law gives there: sigma_d for disparities, whose sigma of depth is z^2/(f b) sigma_d, with q^2/12 of a step q added in
squares. The bands hold equally many pixels, so that a sigma that grows wrongly with depth shows at one of the ends.
"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import frames, noisy_cameras
from plumbline.harness.scene import DepthCamera, StereoNoise, StructuredLightNoise, TimeOfFlightNoise
from plumbline.harness.trajectory import Floats

BANDS = 8
LEAST = 100
"""Pixels that a band has to have."""


def _by_disparity(camera: DepthCamera, law: StereoNoise | StructuredLightNoise, ideal: Floats, depth: Floats) -> Floats:
    sigma, step = law.disparity_sigma, law.disparity_step
    if step > 2.0 * sigma:
        raise NotMeasurable(f"sensor '{camera.name}': a step of {step} px rounds a sigma of {sigma} px to something not normal")
    spread = math.hypot(sigma, step / math.sqrt(12.0))
    return camera.focal_x * law.baseline * (1.0 / depth - 1.0 / ideal) / spread


def _by_range(camera: DepthCamera, law: TimeOfFlightNoise, ideal: Floats, depth: Floats, slant: Floats) -> Floats:
    if law.shot_sigma > 0 or law.multipath > 0:
        raise NotMeasurable(f"sensor '{camera.name}': photon noise and second paths depend on more than depth")
    error, turn = (depth - ideal) * slant, law.unambiguous_range
    if turn is not None:
        error = error - turn * np.rint(error / turn)
    deviation: Floats = error / (law.range_sigma + law.range_sigma_slope * ideal * slant)
    return deviation


def _slant(camera: DepthCamera) -> Floats:
    """Range over z-depth of each pixel, (height, width)."""
    x = (np.arange(camera.width) + 0.5 - camera.centre_x) / camera.focal_x
    y = (np.arange(camera.height) + 0.5 - camera.centre_y) / camera.focal_y
    slant: Floats = np.sqrt(1.0 + np.square(x)[None, :] + np.square(y)[:, None])
    return slant


def deviations(run: Run) -> list[tuple[DepthCamera, Floats, Floats]]:
    """Of each noisy depth camera the ideal depths [m] and the deviations [1], each (k, height, width); inf where invalid.

    Raises:
        NotMeasurable: no camera has a law with a spread, or one's is not of this kind.
    """
    measured = []
    for camera in noisy_cameras(run.scene):
        depth, ideal = frames(run.actual, camera.name, "depth"), frames(run.actual, camera.name, "depth_ideal")
        valid = ~np.isinf(ideal) & (~np.isnan(depth) | np.isnan(ideal))
        slant = np.broadcast_to(_slant(camera), depth.shape)[valid]
        deviation = np.full(depth.shape, np.inf)
        match camera.noise:
            case StereoNoise() | StructuredLightNoise() as law if law.disparity_sigma > 0:
                deviation[valid] = _by_disparity(camera, law, ideal[valid], depth[valid])
            case TimeOfFlightNoise() as law if law.range_sigma + law.range_sigma_slope + law.shot_sigma > 0:
                deviation[valid] = _by_range(camera, law, ideal[valid], depth[valid], slant)
            case _:
                continue
        measured.append((camera, ideal, deviation))
    if not measured:
        raise NotMeasurable("no depth camera of the scene has a noise of depth")
    return measured


def _bands(run: Run) -> list[Floats]:
    """The deviations of each band of each camera, from near to far."""
    bands = []
    for camera, depths, all_deviations in deviations(run):
        valid = ~np.isinf(all_deviations)
        ideal, deviation = depths[valid], all_deviations[valid]
        if len(ideal) < BANDS * LEAST:
            raise NotMeasurable(f"{len(ideal)} pixels of sensor '{camera.name}' are valid, expected at least {BANDS * LEAST}")
        # Pixels of one wall stay in the order of the picture: which band they fall into is not for an engine's rounding to say.
        bands += np.array_split(deviation[np.argsort(np.round(ideal, 9), kind="stable")], BANDS)
    return bands


@metric("1")
def depth_mean_score(run: Run) -> list[float]:
    """standard error of a mean, worst band of depth"""
    return [abs(band.mean()) * np.sqrt(len(band)) for band in _bands(run)]


@metric("1")
def depth_spread_score(run: Run) -> list[float]:
    """Wilson, Hilferty (1931): chi^2 of squares, worst band of depth"""
    # Wilson and Hilferty's cube root makes the chi-squared sum of squares normal to one part in n.
    scores = []
    for band in _bands(run):
        third = 2.0 / (9.0 * len(band))
        scores.append(abs(np.mean(np.square(band)) ** (1 / 3) - (1 - third)) / np.sqrt(third))
    return scores


@metric("1", empty=f"fewer than {LEAST} pairs of neighbouring pixels are valid")
def depth_correlation_score(run: Run) -> list[float]:
    """correlation of neighbouring pixels and frames"""
    # Largest over neighbours in time, row and column: the mean product of deviations is 1/sqrt(n) wide.
    scores = []
    for _, _, deviation in deviations(run):
        for axis in range(3):
            count = deviation.shape[axis]
            a, b = (deviation.take(np.arange(start, count - 1 + start), axis=axis).ravel() for start in (0, 1))
            both = ~np.isinf(a) & ~np.isinf(b)
            if both.sum() >= LEAST:
                scores.append(abs(np.mean(a[both] * b[both])) * np.sqrt(both.sum()))
    return scores
