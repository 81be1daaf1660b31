"""Joints in the engine's words, with their limits, springs and drives."""

from typing import TYPE_CHECKING, Any, assert_never

import numpy as np

from plumbline.harness.scene import Ball, Distance, Drive, Effect, Fixed, Joint, Prismatic, Revolute, Tendon

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["engine_joint", "engine_tendon", "shift_of_target"]

NEVER_REACHED = 1e6
"""A joint's rate [rad/s or m/s] beyond all of a scene: half of it is where a motor of constant torque would begin to fall."""


def engine_joint(joint: Joint, effects: Effect) -> "engine.Joint":
    """A joint, without the drive that the scene leaves out."""
    from plumbline import engine

    ends: dict[str, Any] = {
        "name": joint.name, "parent": joint.parent, "child": joint.child, "collide": joint.collide
    }  # fmt: skip
    match joint:
        case Fixed():
            return engine.Fixed(**ends)
        case Ball():
            return engine.Ball(**ends, anchor_W=joint.anchor_W)
        case Revolute():
            return engine.Revolute(
                **ends,
                anchor_W=joint.anchor_W,
                axis_W=joint.axis_W,
                position=joint.position,
                **_extras(joint, effects),
                **_along(joint),
            )
        case Prismatic():
            return engine.Prismatic(
                **ends,
                anchor_W=joint.anchor_W,
                axis_W=joint.axis_W,
                position=joint.position,
                **_extras(joint, effects),
                **_along(joint),
            )
        case Distance():
            return engine.Distance(
                **ends, anchor_W=joint.anchor_W, child_anchor_W=joint.child_anchor_W, **_extras(joint, effects)
            )
        case _:
            assert_never(joint)


def engine_tendon(tendon: Tendon, effects: Effect) -> "engine.Tendon":
    """A tendon, without the drive that the scene leaves out."""
    from plumbline import engine

    arms = {arm.joint: arm.arm for arm in tendon.arms}
    return engine.Tendon(name=tendon.name, arms=arms, **_extras(tendon, effects))


def _along(joint: Revolute | Prismatic) -> dict[str, Any]:
    """Rotor, dry friction, speed limit and coupling of a joint with one coordinate."""
    from plumbline import engine

    tie = joint.coupling
    return {
        "coupling": None if tie is None else engine.Coupling(joint=tie.joint, ratio=tie.ratio, offset=tie.offset),
        "armature": joint.armature or 0.0,
        "friction_loss": joint.friction_loss or 0.0,
        "speed_limit": np.inf if joint.speed_limit is None else joint.speed_limit,
    }


def _extras(joint: Revolute | Prismatic | Distance | Tendon, effects: Effect) -> dict[str, Any]:
    """Limits, spring and drive of a joint or a tendon."""
    from plumbline import engine

    extras: dict[str, Any] = {}
    if joint.limits is not None:
        lower, upper = joint.limits.lower, joint.limits.upper
        extras["limits"] = engine.Limits(lower=-np.inf if lower is None else lower, upper=np.inf if upper is None else upper)
    if joint.spring is not None:
        spring = joint.spring
        extras["spring"] = engine.Spring(stiffness=spring.stiffness, damping=spring.damping, rest=spring.rest)
    if not isinstance(joint, Distance) and joint.drive is not None and Effect.DRIVES in effects:
        extras["drive"] = _drive(joint.drive)
    return extras


def shift_of_target(drive: Drive) -> float:
    """What a feedforward moves the target by [rad or m]: k (target - x) + b = k (target + b/k - x)."""
    return (drive.feedforward or 0.0) / drive.stiffness if drive.stiffness > 0 else 0.0


def _drive(drive: Drive) -> "engine.Drive":
    """A drive in the engine's law, which knows no feedforward: exact, as a shift of the target or of the target velocity.

    Without stiffness and damping it is a damper towards a rate that nothing reaches, cut off at the torque: at less than half
    of that rate the cut force is the torque to the last bit.
    """
    from plumbline import engine

    limit = np.inf if drive.limit is None else drive.limit
    stiffness, damping, rate = drive.stiffness, drive.damping, drive.target_velocity
    if drive.feedforward and stiffness == 0:
        if damping > 0:
            rate += drive.feedforward / damping
        else:
            limit = min(limit, abs(drive.feedforward))
            damping, rate = 2.0 * limit / NEVER_REACHED, np.copysign(NEVER_REACHED, drive.feedforward)
    return engine.Drive(
        stiffness=stiffness,
        damping=damping,
        target=drive.target + shift_of_target(drive),
        target_velocity=rate,
        limit=limit,
    )
