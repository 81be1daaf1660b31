"""What the joints of Bullet's multibodies carry: the sensors that pybullet has for it, with what these leave out."""

import numpy as np

from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.harness.adapter.joints import about_the_anchor, turned_back
from plumbline.harness.scene import Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import conjugate, product, rotate, rotate_back


class ReactionReader:
    """Reads the sensors of joints, which are switched on at the first question: they cost a pass over all links each step.

    A sensor holds force and torque on the link about its centre of mass, in the link's frame at the start of the (sub)step.
    Torques that were applied are in it, those of motors and limits along the coordinate are not; pybullet tells a motor's, and
    that of a limit or a coupling it does not.
    """

    def __init__(self, scene: Scene, made: Assembly, h: float) -> None:
        self._scene, self._made, self._h = scene, made, h
        self._on = self._measured = False
        followed = {j.coupling.joint for j in scene.joints if isinstance(j, Revolute | Prismatic) and j.coupling is not None}
        self._told = {
            k: joint for k, joint in enumerate(scene.joints) if joint.name in made.hung and _told(joint, joint.name in followed)
        }

    def retime(self, h: float) -> None:
        """The length [s] of the (sub)steps to come."""
        self._h = h

    def stepped(self, count: int) -> None:
        """Steps are taken: if they are listened to, there is something to tell."""
        self._measured = self._measured or (self._on and count > 0)

    def read(self, present: State) -> Floats:
        """Force [N] and torque [N m] of the scene's joints (j, 6) in the last (sub)step; NaN where none was listened to."""
        answer = np.full((len(self._scene.joints), 6), np.nan)
        port, made = self._made.port, self._made
        if not self._on:
            self._on = True
            for joint in self._told.values():
                port.call("enableJointForceTorqueSensor", *made.hung[joint.name], enableSensor=1)
        if not self._measured:
            return answer
        began = turned_back(present, self._h)
        for k, joint in self._told.items():
            number, link = made.hung[joint.name]
            place = made.address[number, link]
            told = port.call("getJointState" if joint.type != "ball" else "getJointStateMultiDof", number, link)
            turn = product(began.q_WB[place][None], conjugate(made.q_IB[place][None]))
            force, torque = rotate(turn, np.array(told[2]).reshape(2, 3))
            if isinstance(joint, Revolute | Prismatic):
                along = told[3] * self._axis(joint, began, place)
                force, torque = (force, torque + along) if isinstance(joint, Revolute) else (force + along, torque)
            answer[k] = about_the_anchor(self._scene, joint, began, place, np.concatenate((force, torque)))
        return answer

    def _axis(self, joint: Revolute | Prismatic, state: State, place: int) -> Floats:
        """The axis (3,) in W along which the link at `place` moves, with the sign of Bullet's coordinate."""
        body = self._scene.bodies[place]
        axis_W = np.asarray(joint.axis_W) * (1.0 if joint.child == body.name else -1.0)
        axis: Floats = rotate(state.q_WB[place][None], rotate_back(np.asarray(body.q_WB)[None], axis_W[None]))[0]
        return axis


def _told(joint: Joint, followed: bool) -> bool:
    """Does pybullet tell all that the joint carries?"""
    return not followed and not (
        isinstance(joint, Revolute | Prismatic) and (joint.limits is not None or joint.coupling is not None)
    )
