"""Pictures and depth images against closed form.

Depth images against closed form, in the pixels that show the body which the truth shows.

Of a depth camera the ideal depth is judged, of a colour camera the depth of its picture. The median is that of the body whose
median is worst, so that a wide wall does not hide a ball.

Colours of a picture against closed form: the largest and the median error of any of red, green and blue.

Where bodies appear in a picture: distance of the centroid of a body's pixels from where it should be, of the worst body.

Silhouettes: the overlap of the pixels that show a body with those that should, over their union; the worst body of all.
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, cameras
from plumbline.harness.metric.series import root_mean_square
from plumbline.harness.scene import Camera, DepthCamera
from plumbline.harness.trajectory import Floats

SOURCE = "closed-form intersection of a pixel's ray with the shapes; z-depth = range times cosine to the optical axis"


def _errors(run: Run) -> list[Floats]:
    """|depth - true depth| [m] of each body of each camera, (n,) each."""
    errors = []
    for camera in cameras(run.scene):
        channel = "depth_ideal" if isinstance(camera, DepthCamera) else "depth"
        depth, truth = beside_truth(run.actual, run.expected, camera.name, channel)
        body, owner = beside_truth(run.actual, run.expected, camera.name, "body")
        # A NaN is no infinity: it is kept, and shows in the error.
        both = (body == owner) & (owner >= 0) & ~np.isinf(depth) & ~np.isinf(truth)
        for place in np.unique(owner[both]):
            shown = both & (owner == place)
            errors.append(np.abs(depth[shown] - truth[shown]))
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


COLOUR_ERROR_SOURCE = (
    "laws of Snell and Fresnel, and reflection, along each pixel's ray; linear colour, 1 is a white surface under a sky of 1"
)


def _colour_errors(run: Run) -> list[Floats]:
    errors = []
    for camera in cameras(run.scene):
        if isinstance(camera, Camera):
            colour, truth = beside_truth(run.actual, run.expected, camera.name, "colour")
            errors.append(np.abs(colour.astype(np.float64) - truth).ravel())
    if not errors:
        raise NotMeasurable("the scene has no colour camera")
    return errors


@metric("1", COLOUR_ERROR_SOURCE)
def colour_error_max(run: Run) -> Floats:
    return np.concatenate(_colour_errors(run))


@metric("1", COLOUR_ERROR_SOURCE)
def colour_error_median(run: Run) -> list[float]:
    """of the worst camera"""
    return [np.median(errors) for errors in _colour_errors(run)]


def _centroid(mask: NDArray[np.bool_]) -> Floats:
    """Mean of the pixels' centres, (u, v) [px]; NaN for no pixel at all."""
    v, u = np.nonzero(mask)
    return np.array([np.mean(u + 0.5), np.mean(v + 0.5)]) if len(u) else np.full(2, np.nan)


@metric("px", empty="the truth shows no body")
def pixel_error(run: Run) -> list[float]:
    """definition: distance of centroids of a body's pixels"""
    # A body that the picture does not show makes it NaN.
    errors = []
    for camera in cameras(run.scene):
        body, owner = beside_truth(run.actual, run.expected, camera.name, "body")
        for shown, due in zip(body, owner, strict=True):
            for place in np.unique(due[due >= 0]):
                errors.append(float(np.linalg.norm(_centroid(shown == place) - _centroid(due == place))))
    return errors


@metric("1", better="higher")
def silhouette_iou(run: Run) -> float:
    """Jaccard's index (1912): intersection over union of sets of pixels"""
    # A body that only the truth or only the picture shows has none.
    shares = []
    for camera in cameras(run.scene):
        body, owner = beside_truth(run.actual, run.expected, camera.name, "body")
        for place in np.union1d(body[body >= 0], owner[owner >= 0]):
            shown, due = body == place, owner == place
            shares.append(float(np.sum(shown & due) / np.sum(shown | due)))
    if not shares:
        raise NotMeasurable("neither picture nor truth shows any body")
    return float(np.min(shares))
