"""Depth images against closed form, in the pixels that show the body which the truth shows.

Of a depth camera the ideal depth is judged, of a colour camera the depth of its picture. The median is that of the body whose
median is worst, so that a wide wall does not hide a ball.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.camera_frames import beside_truth, cameras
from harness.metric.series import maximum, root_mean_square
from harness.scene import DepthCamera, Scene
from harness.trajectory import Floats, Trajectory

SOURCE = "closed-form intersection of a pixel's ray with the shapes; z-depth = range times cosine to the optical axis"


def _errors(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> list[Floats]:
    """|depth - true depth| [m] of each body of each camera, (n,) each."""
    errors = []
    for camera in cameras(scene):
        channel = "depth_ideal" if isinstance(camera, DepthCamera) else "depth"
        depth, truth = beside_truth(actual, expected, camera.name, channel)
        body, owner = beside_truth(actual, expected, camera.name, "body")
        # A NaN is no infinity: it is kept, and shows in the error.
        both = (body == owner) & (owner >= 0) & ~np.isinf(depth) & ~np.isinf(truth)
        for place in np.unique(owner[both]):
            shown = both & (owner == place)
            errors.append(np.abs(depth[shown] - truth[shown]))
    if not errors:
        raise NotMeasurable("no pixel shows the body that the truth shows")
    return errors


def _median(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    return maximum(np.array([np.median(errors) for errors in _errors(scene, actual, expected)]))


DEPTH_ERROR_MEDIAN = Metric(name="depth_error_median", unit="m", source=f"{SOURCE}; median of the worst body", measure=_median)
DEPTH_ERROR_RMS = Metric(
    name="depth_error_rms",
    unit="m",
    source=SOURCE,
    measure=lambda s, a, e: root_mean_square(np.concatenate(_errors(s, a, e))),
)
DEPTH_ERROR_MAX = Metric(
    name="depth_error_max", unit="m", source=SOURCE, measure=lambda s, a, e: maximum(np.concatenate(_errors(s, a, e)))
)

METRIC = (DEPTH_ERROR_MEDIAN, DEPTH_ERROR_RMS, DEPTH_ERROR_MAX)
