"""Foot slip: how far the points that bear a machine wander over the ground."""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import rotate, rotate_back


def _carried(actual: Trajectory, place: int, point_W: Floats) -> Floats:
    """Where a point of a body that is at point_W (3,) in the first sample is at each time, (t, 3) m."""
    arm_B = rotate_back(actual.q_WB[:1, place], (point_W - actual.p_WB[0, place])[None])
    carried: Floats = actual.p_WB[:, place] + rotate(actual.q_WB[:, place], np.broadcast_to(arm_B, (len(actual), 3)))
    return carried


@metric("m")
def foot_slip(run: Run) -> float:
    """static friction holds: greatest way along the ground of the material points that bear on it when the window begins"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    movable = [body.movable for body in run.scene.bodies]
    ways = []
    first = run.actual.contacts[0]
    for a, b, point, normal, force in zip(
        first.body_A, first.body_B, first.point_W, first.normal_W, first.force_W, strict=True
    ):
        # A near miss that an engine lists bears nothing.
        if movable[a] != movable[b] and force.any():
            way = _carried(run.actual, a if movable[a] else b, point) - point
            ways.append(np.linalg.norm(way - np.outer(way @ normal, normal), axis=1).max())
    # A machine that hangs in the air has no foot on the ground that could hold.
    return float(np.max(ways)) if ways else math.inf
