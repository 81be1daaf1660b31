"""Quantisation of disparities: how far they lie off the multiples of the step, and whether neighbours are one step apart."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import frames, noisy_cameras
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import StereoNoise, StructuredLightNoise


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
