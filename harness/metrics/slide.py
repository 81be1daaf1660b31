"""Bodies that slide to a stop: how far, how long, and how level."""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory

SOURCE = "Coulomb friction: d = v0^2/(2 mu g), t = v0/(mu g)"
LEVEL = 0.1
"""The share of its first speed at which a body counts as stopping: high enough that the end of a linear ramp is read between
two samples, where engines regularise friction near zero speed."""


def _movable(scene: Scene) -> list[int]:
    return [place for place, body in enumerate(scene.bodies) if body.movable]


def _truth(expected: Trajectory | None) -> Trajectory:
    if expected is None or len(expected) == 0:
        raise NotMeasurable("no truth to compare with")
    return expected


@metric("1", SOURCE, empty="the truth moves no body")
def stop_distance_error(run: Run) -> list[float]:
    """horizontal way at the end against the truth's, relative, worst body"""
    truth = _truth(run.expected)
    errors = []
    for i in _movable(run.scene):
        start = np.array(run.scene.bodies[i].p_WB)
        true_way = float(np.linalg.norm((truth.p_WB[-1, i] - start)[:2]))
        way = float(np.linalg.norm((run.actual.p_WB[-1, i] - start)[:2]))
        if true_way > 0:
            errors.append(abs(way - true_way) / true_way)
    return errors


def _stopping(time: Floats, speed: Floats) -> float:
    """When a speed (t,) first falls to LEVEL of its first value [s]; infinite where it never does."""
    level = LEVEL * speed[0]
    below = np.flatnonzero(speed <= level)
    if len(below) == 0:
        return math.inf
    k = int(below[0])
    share = (speed[k - 1] - level) / (speed[k - 1] - speed[k])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


@metric("1", SOURCE, empty="the truth stops no body within the run")
def stop_time_error(run: Run) -> list[float]:
    """time to fall to a tenth of the first speed, relative to the truth's, worst body"""
    truth = _truth(run.expected)
    errors = []
    for i in _movable(run.scene):
        true_speed = np.linalg.norm(truth.v_WB[:, i, :2], axis=1)
        if true_speed[0] > 0 and np.isfinite(stop := _stopping(truth.time, true_speed)):
            errors.append(abs(_stopping(run.actual.time, np.linalg.norm(run.actual.v_WB[:, i, :2], axis=1)) - stop) / stop)
    return errors


@metric("m")
def centre_rise(run: Run) -> float:
    """unilateral contact on a level plane: the greatest rise of a centre of mass over its start, worst body"""
    starts = np.array([run.scene.bodies[i].p_WB[2] for i in _movable(run.scene)])
    return float(np.max(run.actual.p_WB[:, _movable(run.scene), 2] - starts))
