"""Depth images against closed form, in the pixels that show the body which the truth shows.

Of a depth camera the ideal depth is judged, of a colour camera the depth of its picture. The median is that of the body whose
median is worst, so that a wide wall does not hide a ball.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, cameras
from plumbline.harness.metric.series import root_mean_square
from plumbline.harness.scene import DepthCamera
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
