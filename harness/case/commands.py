"""What acts on the scene of a case: its own control, and the drives and kinematic bodies that the scene says move."""

from collections.abc import Callable, Mapping

import numpy as np

from plumbline.harness.case.forces import Control, Velocities
from plumbline.harness.scene import WORLD, Effect, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import rotate, rotate_back

Targets = Callable[[float], Mapping[str, float]]


def targets_of(scene: Scene) -> Targets | None:
    """The targets [rad or m] by joint at a time [s] of all drives that have a motion; None where none has, or none acts."""
    if (Effect.JOINTS | Effect.DRIVES) & ~scene.effects:
        return None
    moving = [
        (joint.name, joint.drive.motion, joint.drive.target)
        for joint in scene.joints
        if isinstance(joint, Revolute | Prismatic) and joint.drive is not None and joint.drive.motion is not None
    ]
    if not moving:
        return None
    return lambda time: {name: motion.at(time, target) for name, motion, target in moving}


def velocities_of(scene: Scene) -> Velocities | None:
    """The velocities over a step of all bodies whose motion is prescribed, by a time and a step [s]; None where none is."""
    moving = [(body, body.prescribed) for body in scene.bodies if body.prescribed is not None]
    if not moving:
        return None
    return lambda time, dt: {
        body.name: prescribed.velocity(body.p_WB, body.q_WB, body.v_WB, time, dt) for body, prescribed in moving
    }


def efforts_of(scene: Scene) -> Callable[[float, State], tuple[Floats, Floats]] | None:
    """The forces [N] and torques [N m] in W on all bodies at a time [s] and a state, of joints with an effort; None without.

    A torque t about an axis a is t a on the child and -t a on its parent; a force acts on both at the child's anchor.
    """
    joints = [joint for joint in scene.joints if isinstance(joint, Revolute | Prismatic) and joint.effort is not None]
    if not joints or Effect.JOINTS not in scene.effects:
        return None
    start, count = State.initial(scene), len(scene.bodies)
    ends = [(-1 if joint.parent == WORLD else scene.index(joint.parent), scene.index(joint.child)) for joint in joints]

    def wrench(time: float, state: State) -> tuple[Floats, Floats]:
        f, tau = np.zeros((count, 3)), np.zeros((count, 3))
        for joint, (parent, child) in zip(joints, ends, strict=True):
            assert joint.effort is not None
            axis = np.array(joint.axis_W)
            if parent >= 0:
                axis = rotate(state.q_WB[parent], rotate_back(start.q_WB[parent], axis))
            push = joint.effort.at(time, 0.0) * axis
            if isinstance(joint, Revolute):
                tau[child] += push
                if parent >= 0:
                    tau[parent] -= push
                continue
            arm = rotate(state.q_WB[child], rotate_back(start.q_WB[child], np.array(joint.anchor_W) - start.p_WB[child]))
            for end, sign in ((child, 1.0), (parent, -1.0)):
                if end >= 0:
                    f[end] += sign * push
                    tau[end] += sign * np.cross(state.p_WB[child] + arm - state.p_WB[end], push)
        return f, tau

    return wrench


def acting(scene: Scene, control: Control | None = None) -> Control | None:
    """A case's control together with the motions of its scene's drives and kinematic bodies; None where nothing acts.

    Raises:
        ValueError: both the control and the scene move targets or bodies, or the control is held for an interval.
    """
    targets, velocities, efforts = targets_of(scene), velocities_of(scene), efforts_of(scene)
    if targets is None and velocities is None and efforts is None:
        return control
    if control is None:
        return Control(wrench=efforts, targets=targets, velocities=velocities)
    if control.wrench is not None and efforts is not None:
        raise ValueError("control: it pushes bodies and joints of the scene have an effort, expected one of them to")
    if control.velocities is not None and velocities is not None:
        raise ValueError("control: its bodies and those of the scene both are moved, expected one of them to")
    if control.targets is not None and targets is not None:
        raise ValueError("control: its targets and those of the scene's drives both move, expected one of them to")
    if control.interval > 0.0:
        raise ValueError("control: it is held for an interval, and the scene moves at every step; expected no interval")
    return Control(
        wrench=efforts or control.wrench, targets=targets or control.targets, velocities=velocities or control.velocities
    )
