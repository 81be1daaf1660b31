"""Creep: the speed of bodies that friction should hold."""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if expected is None:
        raise NotMeasurable("no truth to say which bodies stay")
    if len(actual) < 2:
        raise NotMeasurable("fewer than two samples")
    if not actual.finite:
        return math.nan
    still = [i for i, b in enumerate(scene.bodies) if b.movable and not np.any(expected.p_WB[:, i] - expected.p_WB[0, i])]
    if not still:
        raise NotMeasurable("the truth holds no body")
    way = np.linalg.norm(actual.p_WB[-1, still] - actual.p_WB[0, still], axis=1)
    return float(way.max() / (actual.time[-1] - actual.time[0]))


CREEP_SPEED = Metric(
    name="creep_speed",
    unit="m/s",
    source="static friction holds: mean speed over the window of the bodies that the truth keeps in place, worst body",
    measure=_measure,
)

METRIC = CREEP_SPEED
