"""Coordinates and rates of a scene's joints at an instant, as an engine tells them or as the poses of the bodies do.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, section 4.4 (joints as functions of the relative pose).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from plumbline.harness.scene import Ball, Fixed, Scene
from plumbline.harness.trajectory.kinematics import joint_coordinate, joint_rate
from plumbline.harness.trajectory.trajectory import Floats, State, Trajectory


@dataclass(frozen=True, slots=True)
class JointStates:
    """The joints of a scene, in its order; NaN where a joint has no such thing or nobody tells it.

    Terms:
        coordinate (j,) rad or m, rate (j,) per second: of revolute, prismatic and distance joints. reaction (j, 6): force [N]
        and torque [N m] in W that the parent exerts on the child through the joint, springs and drives included, about the
        joint's anchor on the child (of a fixed joint, the child's centre of mass). MuJoCo tells it of this instant, ours as the
        mean over the last step, Bullet and DART of its last sub-step: of a joint that turns at w they differ by w dt of it.
    """

    coordinate: Floats
    rate: Floats
    reaction: Floats

    @classmethod
    def unknown(cls, scene: Scene) -> Self:
        """Room for the joints of a scene, with nothing known."""
        count = len(scene.joints)
        return cls(np.full(count, np.nan), np.full(count, np.nan), np.full((count, 6), np.nan))


def joint_states(scene: Scene, state: State, near: Floats | None = None) -> JointStates:
    """Coordinates and rates that the poses and velocities of the bodies mean, exactly; no reactions, which poses do not tell.

    Args: near (j,): coordinates [rad] of which angles take the branch nearest to; None: that of half a turn about the start.
    """
    states = JointStates.unknown(scene)
    moment = Trajectory.at(state)
    for k, joint in enumerate(scene.joints):
        if isinstance(joint, Fixed | Ball):
            continue
        states.coordinate[k] = joint_coordinate(scene, joint, moment)[0]
        states.rate[k] = joint_rate(scene, joint, moment)[0]
        if near is not None and joint.type == "revolute" and np.isfinite(near[k]):
            states.coordinate[k] += 2.0 * np.pi * np.round((near[k] - states.coordinate[k]) / (2.0 * np.pi))
    return states
