"""Joints between two bodies, described in the world frame at the initial pose."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from plumbline.engine.describe.check import Described, above_zero, direction, finite, not_negative, not_zero, number
from plumbline.engine.maths.arrays import norm

WORLD = "world"
"""The parent of a joint that holds its child to the world."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits(Described):
    """The range of the joint's coordinate [rad or m]."""

    lower: Annotated[float, number] = -math.inf
    upper: Annotated[float, number] = math.inf

    def __post_init__(self) -> None:
        self.check_fields()
        if not (self.lower <= self.upper and self.lower < math.inf and self.upper > -math.inf):
            raise ValueError(f"limits: lower {self.lower}, upper {self.upper}, expected lower at most upper and a range")


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring(Described):
    """f = -stiffness (x - rest) - damping x'."""

    stiffness: Annotated[float, not_negative, "N/m or N m/rad"] = 0.0
    damping: Annotated[float, not_negative, "N s/m or N m s/rad"] = 0.0
    rest: Annotated[float, finite, (), "m or rad"] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive(Described):
    """f = stiffness (target - x) + damping (target_velocity - x'), at most `limit` [N or N m]."""

    stiffness: Annotated[float, not_negative, "N/m or N m/rad"] = 0.0
    damping: Annotated[float, not_negative, "N s/m or N m s/rad"] = 0.0
    target: Annotated[float, finite, (), "m or rad"] = 0.0
    target_velocity: Annotated[float, finite, (), "m/s or rad/s"] = 0.0
    limit: Annotated[float, above_zero] = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Coupling(Described):
    """x = ratio y + offset at all times, of the coordinate y of another joint with one."""

    ELEMENT: ClassVar[str] = "coupling to '{0.joint}'"
    joint: str
    ratio: Annotated[float, not_zero, "1"]
    offset: Annotated[float, finite, (), "rad or m"] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Joint(Described):
    """What every joint has: a name, the bodies that it holds, and whether these collide."""

    ELEMENT: ClassVar[str] = "joint '{0.name}'"
    name: str
    parent: str
    child: str
    collide: bool = False


class Fixed(_Joint):
    """No relative motion."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Ball(_Joint):
    """A point common to both bodies."""

    anchor_W: Annotated[Sequence[float], finite, (3,), "m"]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Scalar(_Joint):
    """A joint with one coordinate; `position` is the coordinate in the initial pose, armature of a rotor that turns with it."""

    anchor_W: Annotated[Sequence[float], finite, (3,), "m"]
    axis_W: Annotated[Sequence[float], direction]
    position: Annotated[float, finite, (), "rad or m"] = 0.0
    limits: Limits | None = None
    spring: Spring | None = None
    drive: Drive | None = None
    armature: Annotated[float, not_negative, "kg m2 or kg"] = 0.0
    friction_loss: Annotated[float, not_negative, "N m or N"] = 0.0
    speed_limit: Annotated[float, above_zero] = math.inf
    coupling: Coupling | None = None


class Revolute(_Scalar):
    """Rotation about an axis alone; `position` [rad] is the coordinate in the initial pose.

    Terms: armature [kg m2]: of a rotor that turns with the coordinate. friction_loss [N m]: bound of a dry friction along it.
    speed_limit [rad/s]: the most that the coordinate's rate may be, either way. coupling: to another joint's coordinate.
    """

    __slots__ = ()


class Prismatic(_Scalar):
    """Translation along an axis of the parent alone; `position` [m] is the coordinate in the initial pose.

    Terms: armature [kg], friction_loss [N], speed_limit [m/s], coupling: as of `Revolute`.
    """

    __slots__ = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Distance(_Joint):
    """The distance of two anchors: kept as it is at the start, or within limits, or held by a spring."""

    anchor_W: Annotated[Sequence[float], finite, (3,), "m"]
    child_anchor_W: Annotated[Sequence[float], finite, (3,), "m"]
    limits: Limits | None = None
    spring: Spring | None = None
    collide: bool = True

    def __post_init__(self) -> None:
        self.check_fields()
        a, b = np.asarray(self.anchor_W, float), np.asarray(self.child_anchor_W, float)
        if float(norm(b - a)) < 1e-12:
            raise ValueError(f"{self.label}: both anchors lie at {a.tolist()} m, expected a distance above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tendon:
    """A length l = sum of arm x over coordinates x of joints with one, and what acts along it: a force f is arm f on each.

    Terms: arms: by the name of a joint [m/rad or 1]. limits, spring, drive: of the length, as a joint has them.
    """

    name: str
    arms: Mapping[str, float]
    limits: Limits | None = None
    spring: Spring | None = None
    drive: Drive | None = None

    def __post_init__(self) -> None:
        if not self.arms:
            raise ValueError(f"tendon '{self.name}': no arms, expected at least one")
        for joint, arm in self.arms.items():
            not_zero(f"tendon '{self.name}'", f"arm of '{joint}'", arm, "m/rad or 1")


Joint = Fixed | Ball | Revolute | Prismatic | Distance
