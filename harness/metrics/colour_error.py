"""Colours of a picture against closed form: the largest and the median error of any of red, green and blue."""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.camera_frames import beside_truth, cameras
from harness.metric.series import maximum
from harness.scene import Camera, Scene
from harness.trajectory import Floats, Trajectory

SOURCE = (
    "laws of Snell and Fresnel, and reflection, along each pixel's ray; linear colour, 1 is a white surface under a sky of 1"
)


def _errors(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> list[Floats]:
    errors = []
    for camera in cameras(scene):
        if isinstance(camera, Camera):
            colour, truth = beside_truth(actual, expected, camera.name, "colour")
            errors.append(np.abs(colour.astype(np.float64) - truth).ravel())
    if not errors:
        raise NotMeasurable("the scene has no colour camera")
    return errors


COLOUR_ERROR_MAX = Metric(
    name="colour_error_max", unit="1", source=SOURCE, measure=lambda s, a, e: maximum(np.concatenate(_errors(s, a, e)))
)
COLOUR_ERROR_MEDIAN = Metric(
    name="colour_error_median",
    unit="1",
    source=f"{SOURCE}; of the worst camera",
    measure=lambda s, a, e: maximum(np.array([np.median(errors) for errors in _errors(s, a, e)])),
)

METRIC = (COLOUR_ERROR_MAX, COLOUR_ERROR_MEDIAN)
