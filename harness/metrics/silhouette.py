"""Silhouettes: the overlap of the pixels that show a body with those that should, over their union; the worst body of all."""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.camera_frames import beside_truth, cameras
from harness.scene import Scene
from harness.trajectory import Trajectory


def _overlap(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    """A body that only the truth or only the picture shows has none."""
    shares = []
    for camera in cameras(scene):
        body, owner = beside_truth(actual, expected, camera.name, "body")
        for place in np.union1d(body[body >= 0], owner[owner >= 0]):
            shown, due = body == place, owner == place
            shares.append(float(np.sum(shown & due) / np.sum(shown | due)))
    if not shares:
        raise NotMeasurable("neither picture nor truth shows any body")
    return float(np.min(shares))


METRIC = SILHOUETTE_IOU = Metric(
    name="silhouette_iou",
    unit="1",
    source="Jaccard's index (1912): intersection over union of sets of pixels",
    better="higher",
    measure=_overlap,
)
