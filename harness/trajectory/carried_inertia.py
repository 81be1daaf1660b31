"""The inertia that a joint carries at the start of a scene."""

import numpy as np

from plumbline.harness.scene import WORLD, Prismatic, Revolute, Scene
from plumbline.harness.trajectory.kinematics import rotate


def carried(scene: Scene, joint: Revolute | Prismatic) -> float:
    """The inertia [kg m2, kg] that a joint carries at the start if all behind it are stiff, its rotor included."""
    behind, grown = {joint.child}, True
    while grown:
        more = {other.child for other in scene.joints if other.parent in behind} - behind
        grown, behind = bool(more), behind | more
    total, axis = joint.armature or 0.0, np.array(joint.axis_W)
    for name in behind - {WORLD}:
        body = scene.body(name)
        if isinstance(joint, Prismatic):
            total += body.mass
            continue
        arm = np.cross(axis, np.array(body.p_WB) - np.array(joint.anchor_W))
        axis_B = rotate(np.array(body.q_WB) * (1.0, -1.0, -1.0, -1.0), axis)
        total += body.mass * float(arm @ arm) + float(axis_B @ np.array(body.inertia) @ axis_B)
    return total
