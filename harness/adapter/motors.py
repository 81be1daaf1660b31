"""Springs, drives and dry friction of a joint as motors: k (target - x) + c (rate - x'), cut off at a limit.

For engines whose joints have motors of this law. A coordinate counts from the start, as such engines do.
"""

import math
from dataclasses import dataclass
from typing import Literal

from plumbline.harness.scene import Drive, Effect, Prismatic, Revolute

NEVER_REACHED = 1e6
"""A rate [rad/s or m/s] beyond all of a scene: a motor towards it gives all its force."""
RIGID = 1e9
"""Damping [N s/m or N m s/rad] over what a dry friction takes: it holds until the solver cuts it off."""


@dataclass(frozen=True, slots=True)
class Motor:
    """One motor. Terms: law: which of the joint's laws it is. limit: of its force, None for none."""

    law: Literal["spring", "drive", "friction"]
    stiffness: float
    damping: float
    target: float
    rate: float
    limit: float | None = None


def motors_of(joint: Revolute | Prismatic, effects: Effect) -> list[Motor]:
    """The motors that a joint's laws take."""
    motors = []
    if joint.spring is not None:
        motors.append(Motor("spring", joint.spring.stiffness, joint.spring.damping, joint.spring.rest - joint.position, 0.0))
    if joint.drive is not None and Effect.DRIVES in effects:
        motors.append(drive_motor(joint.drive, joint.drive.target, joint.position))
    if joint.friction_loss:
        motors.append(Motor("friction", 0.0, RIGID * joint.friction_loss, 0.0, 0.0, joint.friction_loss))
    return motors


def drive_motor(drive: Drive, target: float, position: float) -> Motor:
    """A drive as a motor; a feedforward b shifts its target by b/k, or its rate by b/c, or is all that it has.

    Args: target: that it has now. position: the coordinate at the start [rad or m].
    """
    k, c, push = drive.stiffness, drive.damping, drive.feedforward or 0.0
    if k > 0:
        return Motor("drive", k, c, target - position + push / k, drive.target_velocity, drive.limit)
    if c > 0:
        return Motor("drive", 0.0, c, 0.0, drive.target_velocity + push / c, drive.limit)
    size = min(abs(push), math.inf if drive.limit is None else drive.limit)
    return Motor("drive", 0.0, abs(push), 0.0, math.copysign(NEVER_REACHED, push), size)
