"""Colours of a picture against closed form: the largest and the median error of any of red, green and blue."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, cameras
from plumbline.harness.scene import Camera
from plumbline.harness.trajectory import Floats

SOURCE = (
    "laws of Snell and Fresnel, and reflection, along each pixel's ray; linear colour, 1 is a white surface under a sky of 1"
)


def _errors(run: Run) -> list[Floats]:
    errors = []
    for camera in cameras(run.scene):
        if isinstance(camera, Camera):
            colour, truth = beside_truth(run.actual, run.expected, camera.name, "colour")
            errors.append(np.abs(colour.astype(np.float64) - truth).ravel())
    if not errors:
        raise NotMeasurable("the scene has no colour camera")
    return errors


@metric("1", SOURCE)
def colour_error_max(run: Run) -> Floats:
    return np.concatenate(_errors(run))


@metric("1", SOURCE)
def colour_error_median(run: Run) -> list[float]:
    """of the worst camera"""
    return [np.median(errors) for errors in _errors(run)]
