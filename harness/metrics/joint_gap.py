"""Joint gap: how far a joint's two anchors lie apart where the joint says that they must not."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.scene import Distance, Prismatic
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import across_axis, anchors


def _gap(run: Run) -> Floats:
    """Gap of every joint, (t, joints) m."""
    gaps: list[Floats] = []
    for joint in run.scene.joints:
        on_parent, on_child = anchors(run.scene, joint, run.actual)
        offset: Floats = np.linalg.norm(on_child - on_parent, axis=-1)
        if isinstance(joint, Distance):
            if joint.limits is not None:
                lower = -np.inf if joint.limits.lower is None else joint.limits.lower
                upper = np.inf if joint.limits.upper is None else joint.limits.upper
                gaps.append(np.maximum(np.maximum(lower - offset, offset - upper), offset * 0.0))
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
