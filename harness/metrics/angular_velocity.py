"""Angular velocity error: distance between the angular velocities of answer and truth, in W."""

import numpy as np

from harness.metric.series import matched, three
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable


def _difference(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    truth, bodies = matched(actual, expected), movable(scene)
    difference: Floats = np.linalg.norm(actual.w_WB[:, bodies] - truth.w_WB[:, bodies], axis=-1)
    return difference


METRIC = ANGULAR_VELOCITY_MAX, ANGULAR_VELOCITY_RMS, ANGULAR_VELOCITY_FINAL = three(
    "angular_velocity_error", "rad/s", "definition: |w_WB - w_WB of the truth|", _difference
)
