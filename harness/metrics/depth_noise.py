"""Depth noise against its law: mean and spread of deviations in each band of depth, and independence, as normal scores.

A deviation is what was measured (disparity, or range up to whole wraps) less its ideal value, over the standard deviation that
the law gives there: sigma_d for disparities, whose sigma of depth is z^2/(f b) sigma_d, with q^2/12 of a step q added in
squares. The bands hold equally many pixels, so that a sigma that grows wrongly with depth shows at one of the ends.

Invalid pixels of a depth camera: those that geometry and optics take away, and the share that is lost at random.

The truth's stream '<sensor>/lost' names the first. The score of the second is its distance from the law in the standard
deviations that the law gives it: below z it says that Wilson's interval for confidence z, drawn
about the observed rate, holds the law's.

Quantisation of disparities: how far they lie off the multiples of the step, and whether neighbours are one step apart.

Wrap-around of time of flight: no range is read beyond the unambiguous one, and what lies beyond reads whole turns less.
"""

import math

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, frames, noisy_cameras
from plumbline.harness.metric.noise_scores import mean_score, neighbour_scores, share_score, spread_score
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import DepthCamera, StereoNoise, StructuredLightNoise, TimeOfFlightNoise
from plumbline.harness.trajectory import Floats, Trajectory

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
    return [mean_score(band) for band in _bands(run)]


@metric("1")
def depth_spread_score(run: Run) -> list[float]:
    """Wilson, Hilferty (1931): chi^2 of squares, worst band of depth"""
    return [spread_score(band) for band in _bands(run)]


@metric("1", empty=f"fewer than {LEAST} pairs of neighbouring pixels are valid")
def depth_correlation_score(run: Run) -> list[float]:
    """correlation of neighbouring pixels and frames"""
    # Neighbours in time, row and column.
    return [score for _, _, deviation in deviations(run) for score in neighbour_scores(deviation, LEAST)]


Mask = NDArray[np.bool_]


def _pixels(actual: Trajectory, expected: Trajectory | None, sensor: str) -> tuple[Mask, Mask, Mask] | None:
    """Of all pixels with an ideal depth: those that read nothing, that the truth calls lost; and whether there is any NaN."""
    depth, ideal = frames(actual, sensor, "depth"), frames(actual, sensor, "depth_ideal")
    if expected is None or f"{sensor}/lost" not in expected.streams:
        raise NotMeasurable(f"the truth has no stream '{sensor}/lost'")
    lost = expected.streams[f"{sensor}/lost"]
    _, true_depth = beside_truth(actual, expected, sensor, "depth_ideal")
    if np.isnan(ideal).any():
        return None
    return np.isnan(depth), lost > 0.5, np.isfinite(ideal) & np.isfinite(true_depth)


@metric("1")
def depth_missing_score(run: Run) -> float:
    """Wilson, Probable inference, the law of succession, and statistical inference (1927)"""
    scores = []
    for camera in noisy_cameras(run.scene):
        assert camera.noise is not None
        pixels = _pixels(run.actual, run.expected, camera.name)
        if pixels is None:
            return float("nan")
        silent, lost, seen = pixels
        asked = seen & ~lost
        count, law = int(asked.sum()), camera.noise.missing
        if count == 0:
            raise NotMeasurable(f"no pixel of sensor '{camera.name}' sees what it can measure")
        scores.append(share_score(float(np.mean(silent[asked])), law, count))
    return maximum(np.array(scores))


@metric("1")
def depth_lost_but_answered_share(run: Run) -> float:
    """definition: share of the pixels without a second view, light or texture that read a depth all the same"""
    shares = []
    for camera in noisy_cameras(run.scene):
        pixels = _pixels(run.actual, run.expected, camera.name)
        if pixels is None:
            return float("nan")
        silent, lost, seen = pixels
        if (lost & seen).any():
            shares.append(float(np.mean(~silent[lost & seen])))
    if not shares:
        raise NotMeasurable("the truth takes no pixel away")
    return maximum(np.array(shares))


@metric("1")
def disparity_step_error(run: Run) -> float:
    """Khoshelham, Elberink, Sensors 12 (2012) 1437, section 3: f b / z is a multiple of the step; error in steps"""
    # The larger of both, in steps: a step twice too fine leaves the lattice, one twice too coarse skips a neighbour.
    errors = []
    for camera in noisy_cameras(run.scene):
        law = camera.noise
        if not isinstance(law, StereoNoise | StructuredLightNoise) or law.disparity_step == 0:
            continue
        depth, ideal = frames(run.actual, camera.name, "depth"), frames(run.actual, camera.name, "depth_ideal")
        if np.isnan(ideal).any():
            return float("nan")
        steps = camera.focal_x * law.baseline / depth[np.isfinite(depth)] / law.disparity_step
        levels = np.unique(np.rint(steps))
        if len(levels) < 2:
            raise NotMeasurable(f"sensor '{camera.name}' reads {len(levels)} disparities, expected at least two")
        errors += [np.max(np.abs(steps - np.rint(steps))), abs(np.min(np.diff(levels)) - 1.0)]
    if not errors:
        raise NotMeasurable("no depth camera of the scene quantises disparities")
    return maximum(np.array(errors))


SLACK = 1e-12
"""Relative rounding of the way from a range to a z-depth and back."""


@metric("1")
def range_unwrapped_share(run: Run) -> float:
    """Hansard et al., Time-of-Flight Cameras (2012), chapter 1: a phase tells the range modulo half a wavelength"""
    shares = []
    for camera in noisy_cameras(run.scene):
        law = camera.noise
        if not isinstance(law, TimeOfFlightNoise) or law.unambiguous_range is None:
            continue
        depth, ideal = frames(run.actual, camera.name, "depth"), frames(run.actual, camera.name, "depth_ideal")
        if np.isnan(ideal).any():
            return float("nan")
        slant = _slant(camera)
        valid = np.isfinite(ideal) & ~np.isnan(depth)
        beyond = valid & (ideal * slant > law.unambiguous_range)
        if not beyond.any():
            raise NotMeasurable(f"sensor '{camera.name}' sees nothing beyond its unambiguous range {law.unambiguous_range} m")
        turns = (depth * slant)[valid] / law.unambiguous_range
        shares.append(float(np.mean((turns < 0.0) | (turns > 1.0 + SLACK))))
    if not shares:
        raise NotMeasurable("no depth camera of the scene has an unambiguous range")
    return float(np.max(shares))
