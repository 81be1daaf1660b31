"""Ejection: the speed with which bodies that started in one another part."""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import matched
from harness.scene import Scene
from harness.trajectory import Trajectory
from harness.trajectory.kinematics import movable


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    truth, places = matched(actual, expected), movable(scene)
    pull = np.array(scene.gravity)
    g = float(np.linalg.norm(pull))
    if len(places) == 0 or len(actual) == 0 or g == 0:
        raise NotMeasurable("no movable body, no samples or no gravity to turn a speed into a height")
    if not actual.finite:
        return math.nan
    rise = -(actual.p_WB[:, places] - truth.p_WB[:, places]) @ pull / g
    return math.sqrt(2 * g * max(0.0, float(np.max(rise))))


METRIC = EJECTION_SPEED = Metric(
    name="ejection_speed",
    unit="m/s",
    source="energy of a throw: sqrt(2 g h) of the greatest height h of a centre of mass over where the truth has it at rest",
    measure=_measure,
    verdict="a centre rises over where the truth has it at rest",
)
