"""Velocity error: distance between the velocities of the centres of mass of answer and truth, in W."""

import numpy as np

from harness.metric.series import matched, three
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable


def _difference(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    truth, bodies = matched(actual, expected), movable(scene)
    difference: Floats = np.linalg.norm(actual.v_WB[:, bodies] - truth.v_WB[:, bodies], axis=-1)
    return difference


METRIC = VELOCITY_MAX, VELOCITY_RMS, VELOCITY_FINAL = three(
    "velocity_error", "m/s", "definition: |v_WB - v_WB of the truth|", _difference
)
