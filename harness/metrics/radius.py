"""Radius error: how far bodies leave their distance from the vertical through the origin, as a share of the truth's."""

import numpy as np

from harness.metric import NotMeasurable
from harness.metric.series import matched, three
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable


def _error(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    truth, bodies = matched(actual, expected), movable(scene)
    here, there = (np.hypot(t.p_WB[:, bodies, 0], t.p_WB[:, bodies, 1]) for t in (actual, truth))
    if np.size(there) and not there.min() > 0:
        raise NotMeasurable("the truth passes through the vertical through the origin: there is no radius to compare with")
    error: Floats = np.abs(here / there - 1)
    return error


METRIC = RADIUS_MAX, RADIUS_RMS, RADIUS_FINAL = three(
    "radius_error", "1", "definition: distance from the z axis of W over the truth's, less 1", _error
)
