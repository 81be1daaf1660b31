"""What acts on the scene of a case: its own control, and the targets of those drives that the scene says move."""

from collections.abc import Callable, Mapping

from harness.case.forces import Control
from harness.scene import Effect, Prismatic, Revolute, Scene

__all__ = ["acting", "targets_of"]

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


def acting(scene: Scene, control: Control | None = None) -> Control | None:
    """A case's control together with the motions of its scene's drives; None where nothing acts.

    Raises:
        ValueError: both the control and the scene move targets.
    """
    targets = targets_of(scene)
    if targets is None:
        return control
    if control is None:
        return Control(targets=targets)
    if control.targets is not None:
        raise ValueError("control: its targets and those of the scene's drives both move, expected one of them to")
    if control.interval > 0.0:
        raise ValueError("control: it is held for an interval, and the scene's drives move at every step; expected no interval")
    return Control(wrench=control.wrench, targets=targets)
