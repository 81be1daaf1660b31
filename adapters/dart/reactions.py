"""What DART's joints carry: the force that each body of a skeleton was handed by its joint in the last step."""

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.harness.adapter.joints import about_the_anchor, turned_back
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import rotate


def reactions(built: Built, present: State) -> Floats:
    """Forces [N] and torques [N m] of the scene's joints (j, 6) in the last (sub)step; NaN of those that are constraints.

    `BodyNode.getBodyForce` holds torque and force about the body's origin, in the frame that the body had when the step began,
    with what springs, motors, limits and contacts gave in it.
    """
    scene = built.scene
    answer = np.full((len(scene.joints), 6), np.nan)
    began = turned_back(present, built.world.getTimeStep())
    for k, joint in enumerate(scene.joints):
        if joint.name in built.hung:
            place = built.hung[joint.name]
            told = np.asarray(built.nodes[place].getBodyForce()).reshape(2, 3)
            torque, force = rotate(began.q_WB[place][None], told)
            answer[k] = about_the_anchor(scene, joint, began, place, np.concatenate((force, torque)))
    return answer
