"""What joints give way by: gaps between their anchors, coordinates beyond their stops, poses that drives do not hold."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.scene import Distance, Limits, Prismatic, Revolute
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import across_axis, anchors, joint_coordinate


def _beyond(limits: Limits, x: Floats) -> Floats:
    """How far a coordinate goes beyond its range, (t,) rad or m, 0 within; what is not a number stays so."""
    lower = -np.inf if limits.lower is None else limits.lower
    upper = np.inf if limits.upper is None else limits.upper
    excess: Floats = np.maximum(np.maximum(lower - x, x - upper), 0.0) + 0.0 * x
    return excess


def _gap(run: Run) -> Floats:
    """Gap of every joint, (t, joints) m."""
    gaps: list[Floats] = []
    for joint in run.scene.joints:
        on_parent, on_child = anchors(run.scene, joint, run.actual)
        offset: Floats = np.linalg.norm(on_child - on_parent, axis=-1)
        if isinstance(joint, Distance):
            if joint.limits is not None:
                gaps.append(_beyond(joint.limits, offset))
            elif joint.spring is None:
                gaps.append(np.abs(offset - np.linalg.norm(np.subtract(joint.child_anchor_W, joint.anchor_W))))
        elif isinstance(joint, Prismatic):
            gaps.append(across_axis(run.scene, joint, run.actual))
        else:
            gaps.append(offset)
    if not gaps:
        raise NotMeasurable("the scene has no joint that holds anchors together")
    return np.stack(gaps, axis=1)


joint_gap_max, joint_gap_rms, joint_gap_final = three(
    "joint_gap", "m", "definition: distance between the anchors on parent and child", _gap
)


def _overshoot(run: Run) -> Floats:
    """Excess of every joint with limits, (t, joints), rad or m."""
    overshoots: list[Floats] = []
    for joint in run.scene.joints:
        if isinstance(joint, Revolute | Prismatic | Distance) and joint.limits is not None:
            overshoots.append(_beyond(joint.limits, joint_coordinate(run.scene, joint, run.actual)))
    if not overshoots:
        raise NotMeasurable("no joint of the scene has limits")
    return np.stack(overshoots, axis=1)


limit_overshoot_max, limit_overshoot_rms, limit_overshoot_final = three(
    "limit_overshoot", "rad or m", "definition: joint coordinate beyond its limit", _overshoot
)


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
