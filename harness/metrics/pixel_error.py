"""Where bodies appear in a picture: distance of the centroid of a body's pixels from where it should be, of the worst body."""

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.metric import Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, cameras
from plumbline.harness.trajectory import Floats


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
