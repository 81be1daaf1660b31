"""Overshoot of joint limits: how far a coordinate goes beyond the range that its joint allows."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.scene import Distance, Prismatic, Revolute
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import joint_coordinate


def _overshoot(run: Run) -> Floats:
    """Excess of every joint with limits, (t, joints), rad or m."""
    overshoots: list[Floats] = []
    for joint in run.scene.joints:
        if isinstance(joint, Revolute | Prismatic | Distance) and joint.limits is not None:
            x = joint_coordinate(run.scene, joint, run.actual)
            lower = -np.inf if joint.limits.lower is None else joint.limits.lower
            upper = np.inf if joint.limits.upper is None else joint.limits.upper
            # Adding 0 x keeps what is not a number from hiding behind a maximum with 0.
            overshoots.append(np.maximum(np.maximum(lower - x, x - upper), 0.0) + 0.0 * x)
    if not overshoots:
        raise NotMeasurable("no joint of the scene has limits")
    return np.stack(overshoots, axis=1)


limit_overshoot_max, limit_overshoot_rms, limit_overshoot_final = three(
    "limit_overshoot", "rad or m", "definition: joint coordinate beyond its limit", _overshoot
)
