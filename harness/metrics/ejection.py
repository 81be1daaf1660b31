"""Ejection: the speed with which bodies that started in one another part."""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric


@metric("m/s", verdict="a centre rises over where the truth has it at rest")
def ejection_speed(run: Run) -> float:
    """energy of a throw: sqrt(2 g h) of the greatest height h of a centre of mass over where the truth has it at rest"""
    truth, places = run.truth, run.movable
    pull = np.array(run.scene.gravity)
    g = float(np.linalg.norm(pull))
    if len(places) == 0 or len(run.actual) == 0 or g == 0:
        raise NotMeasurable("no movable body, no samples or no gravity to turn a speed into a height")
    rise = -(run.actual.p_WB[:, places] - truth.p_WB[:, places]) @ pull / g
    return math.sqrt(2 * g * max(0.0, float(np.max(rise))))
