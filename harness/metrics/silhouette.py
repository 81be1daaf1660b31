"""Silhouettes: the overlap of the pixels that show a body with those that should, over their union; the worst body of all."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.camera_frames import beside_truth, cameras


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
