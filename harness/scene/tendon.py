"""Fixed tendons: what pulls at several joints at once, along a length that is a linear combination of their coordinates."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.joint import Drive, Limits, Spring
from plumbline.harness.scene.values import FROZEN, Finite, Name


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class MomentArm:
    """How much a revolute or prismatic joint's coordinate counts in a tendon's length [m/rad or 1 for a length in m]."""

    joint: Name
    arm: Finite

    def __post_init__(self) -> None:
        if self.arm == 0:
            raise ValueError(f"moment arm of '{self.joint}': 0, expected another number; such a joint does not move the tendon")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Tendon:
    """A length l = sum of arm x over the coordinates x of joints, with the laws that a joint has along its coordinate.

    A force f along it is a force or torque of arm f on each of them. Spring, drive and limits are those of the length, in the
    units that the arms give it. A drive of a tendon has no motion.

    Source: MuJoCo, XML reference, tendon/fixed.
    """

    name: Name
    arms: Annotated[tuple[MomentArm, ...], Field(min_length=1)]
    limits: Limits | None = None
    spring: Spring | None = None
    drive: Drive | None = None

    def __post_init__(self) -> None:
        joints = [arm.joint for arm in self.arms]
        if twice := next((joint for joint in joints if joints.count(joint) > 1), None):
            raise ValueError(f"tendon '{self.name}': joint '{twice}' stands twice, expected one arm")
        if self.drive is not None and self.drive.motion is not None:
            raise ValueError(f"tendon '{self.name}': its drive has a motion, expected a target that stays")
