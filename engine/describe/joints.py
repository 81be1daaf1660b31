"""Joints between two bodies, described in the world frame at the initial pose."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbline.engine.describe.check import direction, finite, not_negative, number
from plumbline.engine.maths.arrays import norm

WORLD = "world"
"""The parent of a joint that holds its child to the world."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The range of the joint's coordinate [rad or m]."""

    lower: float = -math.inf
    upper: float = math.inf

    def __post_init__(self) -> None:
        lower, upper = number("limits", "lower", self.lower), number("limits", "upper", self.upper)
        if not (lower <= upper and lower < math.inf and upper > -math.inf):
            raise ValueError(f"limits: lower {self.lower}, upper {self.upper}, expected lower at most upper and a range")


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """f = -stiffness (x - rest) - damping x'."""

    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0

    def __post_init__(self) -> None:
        not_negative("spring", "stiffness", self.stiffness, "N/m or N m/rad")
        not_negative("spring", "damping", self.damping, "N s/m or N m s/rad")
        finite("spring", "rest", self.rest, (), "m or rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """f = stiffness (target - x) + damping (target_velocity - x'), at most `limit` [N or N m]."""

    stiffness: float = 0.0
    damping: float = 0.0
    target: float = 0.0
    target_velocity: float = 0.0
    limit: float = math.inf

    def __post_init__(self) -> None:
        not_negative("drive", "stiffness", self.stiffness, "N/m or N m/rad")
        not_negative("drive", "damping", self.damping, "N s/m or N m s/rad")
        finite("drive", "target", self.target, (), "m or rad")
        finite("drive", "target_velocity", self.target_velocity, (), "m/s or rad/s")
        if not number("drive", "limit", self.limit) > 0:
            raise ValueError(f"drive: limit {self.limit}, expected above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Coupling:
    """x = ratio y + offset at all times, of the coordinate y of another joint with one."""

    joint: str
    ratio: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        finite(f"coupling to '{self.joint}'", "offset", self.offset, (), "rad or m")
        if finite(f"coupling to '{self.joint}'", "ratio", self.ratio, (), "1") == 0:
            raise ValueError(f"coupling to '{self.joint}': ratio {self.ratio}, expected another than 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fixed:
    """No relative motion."""

    name: str
    parent: str
    child: str
    collide: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Ball:
    """A point common to both bodies."""

    name: str
    parent: str
    child: str
    anchor_W: Sequence[float]
    collide: bool = False

    def __post_init__(self) -> None:
        finite(f"joint '{self.name}'", "anchor_W", self.anchor_W, (3,), "m")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Scalar:
    """A joint with one coordinate; `position` is the coordinate in the initial pose, armature of a rotor that turns with it."""

    name: str
    parent: str
    child: str
    anchor_W: Sequence[float]
    axis_W: Sequence[float]
    position: float = 0.0
    limits: Limits | None = None
    spring: Spring | None = None
    drive: Drive | None = None
    armature: float = 0.0
    friction_loss: float = 0.0
    speed_limit: float = math.inf
    coupling: Coupling | None = None
    collide: bool = False

    def __post_init__(self) -> None:
        label = f"joint '{self.name}'"
        finite(label, "anchor_W", self.anchor_W, (3,), "m")
        direction(label, "axis_W", self.axis_W)
        finite(label, "position", self.position, (), "rad or m")
        not_negative(label, "armature", self.armature, "kg m2 or kg")
        not_negative(label, "friction_loss", self.friction_loss, "N m or N")
        if not number(label, "speed_limit", self.speed_limit) > 0:
            raise ValueError(f"{label}: speed_limit {self.speed_limit}, expected above 0")


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
class Distance:
    """The distance of two anchors: kept as it is at the start, or within limits, or held by a spring."""

    name: str
    parent: str
    child: str
    anchor_W: Sequence[float]
    child_anchor_W: Sequence[float]
    limits: Limits | None = None
    spring: Spring | None = None
    collide: bool = True

    def __post_init__(self) -> None:
        a = finite(f"joint '{self.name}'", "anchor_W", self.anchor_W, (3,), "m")
        b = finite(f"joint '{self.name}'", "child_anchor_W", self.child_anchor_W, (3,), "m")
        if float(norm(b - a)) < 1e-12:
            raise ValueError(f"joint '{self.name}': both anchors lie at {a.tolist()} m, expected a distance above 0")


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
            if finite(f"tendon '{self.name}'", f"arm of '{joint}'", arm, (), "m/rad or 1") == 0:
                raise ValueError(f"tendon '{self.name}': arm of '{joint}' {arm}, expected another than 0")


Joint = Fixed | Ball | Revolute | Prismatic | Distance
