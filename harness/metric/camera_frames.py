"""Frames of cameras, read off a trajectory and beside those of its truth."""

import numpy as np

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.scene import Camera, DepthCamera, Scene
from plumbline.harness.trajectory import Floats, Trajectory


def cameras(scene: Scene) -> tuple[Camera | DepthCamera, ...]:
    """All cameras of a scene. Raises: NotMeasurable where it has none."""
    sensors = tuple(sensor for sensor in scene.sensors if isinstance(sensor, Camera | DepthCamera))
    if not sensors:
        raise NotMeasurable("the scene has no camera")
    return sensors


def noisy_cameras(scene: Scene) -> tuple[DepthCamera, ...]:
    """The depth cameras of a scene that have noise. Raises: NotMeasurable where there is none."""
    noisy = tuple(sensor for sensor in scene.sensors if isinstance(sensor, DepthCamera) and sensor.noise is not None)
    if not noisy:
        raise NotMeasurable("no depth camera of the scene has a noise model")
    return noisy


def frames(trajectory: Trajectory, sensor: str, channel: str) -> Floats:
    """The stream '<sensor>/<channel>' (k, height, width, ...) with k > 0. Raises: NotMeasurable where there is none."""
    recorded = trajectory.streams.get(f"{sensor}/{channel}")
    if recorded is None or len(recorded) == 0:
        raise NotMeasurable(f"stream '{sensor}/{channel}' was not recorded")
    return recorded


def beside_truth(actual: Trajectory, expected: Trajectory | None, sensor: str, channel: str) -> tuple[Floats, Floats]:
    """The stream '<sensor>/<channel>' and the truth's, both (k, height, width, ...), taken at the same times.

    Raises:
        NotMeasurable: one of them is missing, or they differ in time or size.
    """
    name, stamps = f"{sensor}/{channel}", f"{sensor}/time"
    recorded = frames(actual, sensor, channel)
    if expected is None or name not in expected.streams:
        raise NotMeasurable(f"the truth has no stream '{name}'")
    here, there, truth = actual.streams[stamps], expected.streams[stamps], expected.streams[name]
    if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
        raise NotMeasurable(f"the truth of '{name}' stands at other times than the frames")
    if recorded.shape != truth.shape:
        raise NotMeasurable(f"frames '{name}' of shape {recorded.shape} against a truth of shape {truth.shape}")
    return recorded, truth
