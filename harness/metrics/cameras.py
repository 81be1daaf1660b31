"""Pictures and depth images of cameras: against closed form, and their noise against its law.

Depth is judged in the pixels that show the body which the truth shows: of a depth camera the ideal depth, of a colour camera
that of its picture. The median is that of the body whose median is worst, so that a wide wall does not hide a ball.

A deviation is what was measured (disparity, or range up to whole wraps) less its ideal value, over the standard deviation that
the law gives there: sigma_d for disparities, whose sigma of depth is z^2/(f b) sigma_d, with q^2/12 of a step q added in
squares. The bands hold equally many pixels, so that a sigma that grows wrongly with depth shows at one of the ends.

Invalid pixels are those that geometry and optics take away, which the truth's stream '<sensor>/lost' names, and the share that
is lost at random. The score of the second is its distance from the law in the standard deviations that the law gives it: below
z it says that Wilson's interval for confidence z, drawn about the observed rate, holds the law's.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.noise_scores import mean_score, neighbour_scores, share_score, spread_score
from plumbline.harness.metric.series import root_mean_square
from plumbline.harness.scene import Camera, DepthCamera, StereoNoise, StructuredLightNoise, TimeOfFlightNoise
from plumbline.harness.trajectory import Floats

SOURCE = "closed-form intersection of a pixel's ray with the shapes; z-depth = range times cosine to the optical axis"
COLOUR_ERROR_SOURCE = (
    "laws of Snell and Fresnel, and reflection, along each pixel's ray; linear colour, 1 is a white surface under a sky of 1"
)
BANDS = 8
LEAST = 100
"""Pixels that a band has to have."""
SLACK = 1e-12
"""Relative rounding of the way from a range to a z-depth and back."""
Mask = NDArray[np.bool_]


def _cameras(run: Run) -> tuple[Camera | DepthCamera, ...]:
    cameras = tuple(sensor for sensor in run.scene.sensors if isinstance(sensor, Camera | DepthCamera))
    if not cameras:
        raise NotMeasurable("the scene has no camera")
    return cameras


def _owners(run: Run) -> Iterator[tuple[Floats, Floats]]:
    """Of each camera which body each pixel shows, -1 for none, and which it has to, (k, height, width)."""
    for camera in _cameras(run):
        yield run.beside_truth(camera.name, "body")


def _errors(run: Run) -> list[Floats]:
    """|depth - true depth| [m] of each body of each camera, (n,) each."""
    errors = []
    for camera, (body, owner) in zip(_cameras(run), _owners(run), strict=True):
        depth, truth = run.beside_truth(camera.name, "depth_ideal" if isinstance(camera, DepthCamera) else "depth")
        # A NaN is no infinity: it is kept, and shows in the error.
        both = (body == owner) & (owner >= 0) & ~np.isinf(depth) & ~np.isinf(truth)
        shown = (both & (owner == place) for place in np.unique(owner[both]))
        errors += [np.abs(depth[own] - truth[own]) for own in shown]
    if not errors:
        raise NotMeasurable("no pixel shows the body that the truth shows")
    return errors


@metric("m", SOURCE)
def depth_error_median(run: Run) -> list[float]:
    """median of the worst body"""
    return [np.median(errors) for errors in _errors(run)]


@metric("m", SOURCE)
def depth_error_rms(run: Run) -> float:
    return root_mean_square(np.concatenate(_errors(run)))


@metric("m", SOURCE)
def depth_error_max(run: Run) -> Floats:
    return np.concatenate(_errors(run))


def _colour_errors(run: Run) -> list[Floats]:
    """Of any of red, green and blue, of each colour camera."""
    colours = (run.beside_truth(camera.name, "colour") for camera in run.sensors(Camera, "no colour camera"))
    return [np.abs(colour.astype(np.float64) - truth).ravel() for colour, truth in colours]


@metric("1", COLOUR_ERROR_SOURCE)
def colour_error_max(run: Run) -> Floats:
    return np.concatenate(_colour_errors(run))


@metric("1", COLOUR_ERROR_SOURCE)
def colour_error_median(run: Run) -> list[float]:
    """of the worst camera"""
    return [np.median(errors) for errors in _colour_errors(run)]


def _centroid(mask: Mask) -> Floats:
    """Mean of the pixels' centres, (u, v) [px]; NaN for no pixel at all."""
    v, u = np.nonzero(mask)
    return np.array([np.mean(u + 0.5), np.mean(v + 0.5)]) if len(u) else np.full(2, np.nan)


@metric("px", empty="the truth shows no body")
def pixel_error(run: Run) -> list[float]:
    """definition: distance of centroids of a body's pixels"""
    # A body that the picture does not show makes it NaN.
    return [
        float(np.linalg.norm(_centroid(shown == place) - _centroid(due == place)))
        for body, owner in _owners(run)
        for shown, due in zip(body, owner, strict=True)
        for place in np.unique(due[due >= 0])
    ]


@metric("1", better="higher")
def silhouette_iou(run: Run) -> float:
    """Jaccard's index (1912): intersection over union of sets of pixels"""
    # A body that only the truth or only the picture shows has none.
    shares = []
    for body, owner in _owners(run):
        for place in np.union1d(body[body >= 0], owner[owner >= 0]):
            shown, due = body == place, owner == place
            shares.append(float(np.sum(shown & due) / np.sum(shown | due)))
    if not shares:
        raise NotMeasurable("neither picture nor truth shows any body")
    return min(shares)


Pixels = tuple[DepthCamera, Floats, Floats]
"""A depth camera that has noise, the depths [m] that it reads and the ideal ones, (k, height, width)."""


def _noisy(run: Run) -> Iterator[Pixels]:
    noisy = [sensor for sensor in run.scene.sensors if isinstance(sensor, DepthCamera) and sensor.noise is not None]
    if not noisy:
        raise NotMeasurable("no depth camera of the scene has a noise model")
    return ((c, run.stream(f"{c.name}/depth"), run.stream(f"{c.name}/depth_ideal")) for c in noisy)


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


def deviations(run: Run) -> list[Pixels]:
    """Of each noisy depth camera the ideal depths [m] and the deviations [1], each (k, height, width); inf where invalid.

    Raises:
        NotMeasurable: no camera has a law with a spread, or one's is not of this kind.
    """
    measured = []
    for camera, depth, ideal in _noisy(run):
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


def _pixels(run: Run, pixels: Pixels) -> tuple[Mask, Mask, Mask] | None:
    """Of all pixels with an ideal depth: those that read nothing, that the truth calls lost; and whether there is any NaN."""
    camera, depth, ideal = pixels
    lost = run.true_stream(f"{camera.name}/lost")
    _, true_depth = run.beside_truth(camera.name, "depth_ideal")
    if np.isnan(ideal).any():
        return None
    return np.isnan(depth), lost > 0.5, np.isfinite(ideal) & np.isfinite(true_depth)


@metric("1")
def depth_missing_score(run: Run) -> list[float]:
    """Wilson, Probable inference, the law of succession, and statistical inference (1927)"""
    scores = []
    for camera in _noisy(run):
        pixels, noise = _pixels(run, camera), camera[0].noise
        assert noise is not None
        if pixels is None:
            return [float("nan")]
        silent, lost, seen = pixels
        asked = seen & ~lost
        if not asked.any():
            raise NotMeasurable(f"no pixel of sensor '{camera[0].name}' sees what it can measure")
        scores.append(share_score(float(np.mean(silent[asked])), noise.missing, int(asked.sum())))
    return scores


@metric("1", empty="the truth takes no pixel away")
def depth_lost_but_answered_share(run: Run) -> list[float]:
    """definition: share of the pixels without a second view, light or texture that read a depth all the same"""
    shares = []
    for camera in _noisy(run):
        pixels = _pixels(run, camera)
        if pixels is None:
            return [float("nan")]
        silent, lost, seen = pixels
        if (lost & seen).any():
            shares.append(float(np.mean(~silent[lost & seen])))
    return shares


@metric("1", empty="no depth camera of the scene quantises disparities")
def disparity_step_error(run: Run) -> list[float]:
    """Khoshelham, Elberink, Sensors 12 (2012) 1437, section 3: f b / z is a multiple of the step; error in steps"""
    # The larger of both, in steps: a step twice too fine leaves the lattice, one twice too coarse skips a neighbour.
    errors = []
    for camera, depth, ideal in _noisy(run):
        law = camera.noise
        if not isinstance(law, StereoNoise | StructuredLightNoise) or law.disparity_step == 0:
            continue
        if np.isnan(ideal).any():
            return [float("nan")]
        steps = camera.focal_x * law.baseline / depth[np.isfinite(depth)] / law.disparity_step
        levels = np.unique(np.rint(steps))
        if len(levels) < 2:
            raise NotMeasurable(f"sensor '{camera.name}' reads {len(levels)} disparities, expected at least two")
        errors += [np.max(np.abs(steps - np.rint(steps))), abs(np.min(np.diff(levels)) - 1.0)]
    return errors


@metric("1", empty="no depth camera of the scene has an unambiguous range")
def range_unwrapped_share(run: Run) -> list[float]:
    """Hansard et al., Time-of-Flight Cameras (2012), chapter 1: a phase tells the range modulo half a wavelength"""
    # No range is read beyond the unambiguous one, and what lies beyond reads whole turns less.
    shares = []
    for camera, depth, ideal in _noisy(run):
        law = camera.noise
        if not isinstance(law, TimeOfFlightNoise) or law.unambiguous_range is None:
            continue
        if np.isnan(ideal).any():
            return [float("nan")]
        slant = _slant(camera)
        valid = np.isfinite(ideal) & ~np.isnan(depth)
        if not (valid & (ideal * slant > law.unambiguous_range)).any():
            raise NotMeasurable(f"sensor '{camera.name}' sees nothing beyond its unambiguous range {law.unambiguous_range} m")
        turns = (depth * slant)[valid] / law.unambiguous_range
        shares.append(float(np.mean((turns < 0.0) | (turns > 1.0 + SLACK))))
    return shares
