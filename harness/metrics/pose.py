"""Pose error: how far the hinges of a machine are from where the truth has them."""

import numpy as np

from harness.metric import NotMeasurable
from harness.metric.series import matched, three
from harness.scene import Revolute, Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import joint_coordinate


def _errors(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    """Of every hinge, (t, hinges) rad."""
    truth = matched(actual, expected)
    hinges = [joint for joint in scene.joints if isinstance(joint, Revolute)]
    if not hinges:
        raise NotMeasurable("the scene has no hinge")
    if not actual.finite:
        return np.full((1, 1), np.nan)
    return np.stack(
        [np.abs(joint_coordinate(scene, joint, actual) - joint_coordinate(scene, joint, truth)) for joint in hinges], axis=1
    )


METRIC = POSE_ERROR_MAX, POSE_ERROR_RMS, POSE_ERROR_FINAL = three(
    "pose_error", "rad", "definition: distance of a hinge's angle from the truth's, over all hinges", _errors
)
