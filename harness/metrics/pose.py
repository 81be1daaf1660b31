"""Pose error: how far the hinges of a machine are from where the truth has them."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.scene import Revolute
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import joint_coordinate


def _errors(run: Run) -> Floats:
    """Of every hinge, (t, hinges) rad."""
    truth = run.truth
    hinges = [joint for joint in run.scene.joints if isinstance(joint, Revolute)]
    if not hinges:
        raise NotMeasurable("the scene has no hinge")
    return np.stack(
        [
            np.abs(joint_coordinate(run.scene, joint, run.actual) - joint_coordinate(run.scene, joint, truth))
            for joint in hinges
        ],
        axis=1,
    )


pose_error_max, pose_error_rms, pose_error_final = three(
    "pose_error", "rad", "definition: distance of a hinge's angle from the truth's, over all hinges", _errors
)
