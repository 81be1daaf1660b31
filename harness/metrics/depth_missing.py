"""Invalid pixels of a depth camera: those that geometry and optics take away, and the share that is lost at random.

The truth's stream '<sensor>/lost' names the first. The score of the second is its distance from the law in the standard
deviations that the law gives it: below z it says that Wilson's interval for confidence z, drawn
about the observed rate, holds the law's.
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, frames, noisy_cameras
from plumbline.harness.metric.series import maximum
from plumbline.harness.trajectory import Trajectory

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
        rate, width = float(np.mean(silent[asked])), float(np.sqrt(law * (1 - law) / count))
        scores.append(abs(rate - law) / width if width > 0 else (0.0 if rate == law else np.inf))
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
