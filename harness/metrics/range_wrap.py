"""Wrap-around of time of flight: no range is read beyond the unambiguous one, and what lies beyond reads whole turns less."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import frames, noisy_cameras
from plumbline.harness.scene import TimeOfFlightNoise

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
        x = (np.arange(camera.width) + 0.5 - camera.centre_x) / camera.focal_x
        y = (np.arange(camera.height) + 0.5 - camera.centre_y) / camera.focal_y
        slant = np.sqrt(1.0 + np.square(x)[None, :] + np.square(y)[:, None])
        valid = np.isfinite(ideal) & ~np.isnan(depth)
        beyond = valid & (ideal * slant > law.unambiguous_range)
        if not beyond.any():
            raise NotMeasurable(f"sensor '{camera.name}' sees nothing beyond its unambiguous range {law.unambiguous_range} m")
        turns = (depth * slant)[valid] / law.unambiguous_range
        shares.append(float(np.mean((turns < 0.0) | (turns > 1.0 + SLACK))))
    if not shares:
        raise NotMeasurable("no depth camera of the scene has an unambiguous range")
    return float(np.max(shares))
