"""Joints: what two bodies may do relative to each other, with limits, springs and drives.

A joint's coordinate is the angle [rad] or the way [m] of the child against the parent along the axis; `position` is its
value in the scene's initial pose, so that limits, springs and targets need not be counted from there.
A fixed tendon pulls at several joints at once.
"""

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.motion import Motion
from plumbline.harness.scene.values import FROZEN, Axis, Finite, Name, NonNegative, Positive, Vector3

WORLD = "world"
"""The parent of a joint that holds its child to the world."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Limits:
    """The range [lower, upper] of a joint's coordinate [rad or m]; None leaves that side open."""

    lower: float | None = None
    upper: float | None = None

    def __post_init__(self) -> None:
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise ValueError(f"limits: lower {self.lower} lies above upper {self.upper}")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Spring:
    """A passive spring and damper: -stiffness (x - rest) - damping x', in N/m and N s/m or N m/rad and N m s/rad."""

    stiffness: NonNegative = 0.0
    damping: NonNegative = 0.0
    rest: Finite = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Drive:
    """A PD drive: stiffness (target - x) + damping (target_velocity - x') + feedforward, cut off at `limit` (None: none).

    Terms: feedforward, limit [N or N m]. With feedforward alone it is a motor of constant torque or force. motion: how the
    target moves; None where it stays.
    """

    stiffness: NonNegative = 0.0
    damping: NonNegative = 0.0
    target: Finite = 0.0
    target_velocity: Finite = 0.0
    limit: Positive | None = None
    feedforward: Finite | None = None
    motion: Motion | None = None

    def __post_init__(self) -> None:
        if self.motion is not None and self.stiffness == 0:
            raise ValueError("drive: its target moves and its stiffness is 0, expected a stiffness that follows it")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Coupling:
    """A linear tie to the coordinate y of another revolute or prismatic joint: x = ratio y + offset [rad or m] at all times."""

    joint: Name
    ratio: Finite
    offset: Finite = 0.0

    def __post_init__(self) -> None:
        if self.ratio == 0:
            raise ValueError(f"coupling to '{self.joint}': ratio is 0, expected another number; a fixed joint does not move")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Fixed:
    """No relative motion."""

    name: Name
    parent: Name
    child: Name
    collide: bool = False
    type: Literal["fixed"] = "fixed"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Ball:
    """The anchor [m, in W at time 0] stays common to both bodies; all rotations are free."""

    name: Name
    parent: Name
    child: Name
    anchor_W: Vector3
    collide: bool = False
    type: Literal["ball"] = "ball"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class OneAxis:
    """One coordinate about or along `axis_W` through `anchor_W` (both in W at time 0).

    Terms: effort [N m or N]: a law of time that acts on the coordinate from outside, on both bodies, beside any drive.
    """

    name: Name
    parent: Name
    child: Name
    anchor_W: Vector3
    axis_W: Axis
    position: Finite = 0.0
    limits: Limits | None = None
    spring: Spring | None = None
    drive: Drive | None = None
    armature: NonNegative | None = None
    friction_loss: NonNegative | None = None
    speed_limit: Positive | None = None
    coupling: Coupling | None = None
    effort: Motion | None = None
    collide: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Revolute(OneAxis):
    """Rotation about `axis_W` through `anchor_W` (both in W at time 0) alone.

    Terms:
        armature [kg m2]: inertia of the rotor that turns with the coordinate alone: the joint resists x'' by -armature x''.
        friction_loss [N m]: the greatest size of a dry friction along the coordinate: it opposes x', and holds where x' is 0.
        speed_limit [rad/s]: the most that |x'| may be: at it, whatever torque that takes keeps x' there, and acts on both.
        coupling: the tie to another joint's coordinate. None: none, as 0.
    """

    type: Literal["revolute"] = "revolute"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Prismatic(OneAxis):
    """Translation along `axis_W` (in W at time 0, fixed in the parent) alone.

    Terms:
        armature [kg]: inertia of the rotor that turns with the coordinate alone: the joint resists x'' by -armature x''.
        friction_loss [N]: the greatest size of a dry friction along the coordinate: it opposes x', and holds where x' is 0.
        speed_limit [m/s]: the most that |x'| may be: at it, whatever force that takes keeps x' there, and acts on both.
        coupling: the tie to another joint's coordinate. None: none, as 0.
    """

    type: Literal["prismatic"] = "prismatic"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Distance:
    """The distance between an anchor on the parent and one on the child: a rod, or a rope or spring if told so.

    Without limits and spring the initial distance is kept; with limits it may move between them; a spring's rest is in m.
    """

    name: Name
    parent: Name
    child: Name
    anchor_W: Vector3
    child_anchor_W: Vector3
    limits: Limits | None = None
    spring: Spring | None = None
    collide: bool = True
    type: Literal["distance"] = "distance"

    def __post_init__(self) -> None:
        if self.anchor_W == self.child_anchor_W:
            raise ValueError(f"joint '{self.name}': both anchors lie at {self.anchor_W}, expected a distance above 0")


Joint = Annotated[Fixed | Ball | Revolute | Prismatic | Distance, Field(discriminator="type")]


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
