"""What acts on the scene of a case: its own control, and the drives and kinematic bodies that the scene says move."""

from collections.abc import Callable, Mapping

from plumbline.harness.case.forces import Control, Velocities
from plumbline.harness.scene import Effect, Prismatic, Revolute, Scene

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


def acting(scene: Scene, control: Control | None = None) -> Control | None:
    """A case's control together with the motions of its scene's drives and kinematic bodies; None where nothing acts.

    Raises:
        ValueError: both the control and the scene move targets or bodies, or the control is held for an interval.
    """
    targets, velocities = targets_of(scene), velocities_of(scene)
    if targets is None and velocities is None:
        return control
    if control is None:
        return Control(targets=targets, velocities=velocities)
    if control.velocities is not None and velocities is not None:
        raise ValueError("control: its bodies and those of the scene both are moved, expected one of them to")
    if control.targets is not None and targets is not None:
        raise ValueError("control: its targets and those of the scene's drives both move, expected one of them to")
    if control.interval > 0.0:
        raise ValueError("control: it is held for an interval, and the scene moves at every step; expected no interval")
    return Control(wrench=control.wrench, targets=targets or control.targets, velocities=velocities or control.velocities)
