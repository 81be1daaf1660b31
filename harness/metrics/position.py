"""Position error: distance between the centres of mass of answer and truth, over the bodies that a force moves."""

import numpy as np

from harness.metric.series import matched, three
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable


def _distance(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    truth, bodies = matched(actual, expected), movable(scene)
    distance: Floats = np.linalg.norm(actual.p_WB[:, bodies] - truth.p_WB[:, bodies], axis=-1)
    return distance


METRIC = POSITION_MAX, POSITION_RMS, POSITION_FINAL = three(
    "position_error", "m", "definition: |p_WB - p_WB of the truth|", _distance
)
