"""Where the links of a robot are at the start, how they move, and along which lines their coordinates act."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose, crossed, screw
from plumbline.harness.scene.importers.robot import Coordinate, Robot


@dataclass(frozen=True, slots=True, eq=False)
class Twist:
    """A motion: angular velocity w [rad/s] and the velocity v [m/s] of the point of the body that is at W's origin."""

    w: Array
    v: Array

    def __add__(self, other: "Twist") -> "Twist":
        return Twist(self.w + other.w, self.v + other.v)

    def at(self, point: Array) -> Array:
        """The velocity of the body's point at a place [m] of W."""
        moved: Array = self.v + crossed(self.w, point)
        return moved


STILL = Twist(np.zeros(3), np.zeros(3))


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A coordinate at the start. Terms: anchor_W [m], axis_W: the line. unit: the motion of what hangs on it at rate 1.
    after: pose in W of what it moves, which is the link where it is its last one. twist: of the same."""

    coordinate: Coordinate
    anchor_W: Array
    axis_W: Array
    after: Pose
    twist: Twist

    @property
    def unit(self) -> Twist:
        """The motion of what hangs on it at a rate of 1."""
        if self.coordinate.kind == "prismatic":
            return Twist(np.zeros(3), self.axis_W)
        return Twist(self.axis_W, crossed(self.anchor_W, self.axis_W))


@dataclass(frozen=True, slots=True, eq=False)
class Posed:
    """All links at the start, by name. Terms: pose in W; twist; lines of each link's coordinates in their order."""

    pose: dict[str, Pose]
    twist: dict[str, Twist]
    lines: dict[str, tuple[Line, ...]]


def posed(robot: Robot, base: Pose, base_twist: Twist = STILL) -> Posed:
    """Forward kinematics: the robot with its root's parent at `base`.

    Args: base: the frame in W that the file calls the world; base_twist: of a free root.
    """
    poses = Posed({}, {}, {})
    for link in robot.links:
        above = base if link.parent is None else poses.pose[link.parent]
        twist = STILL if link.parent is None else poses.twist[link.parent]
        here, lines = above @ link.X_PL, []
        for c in link.coordinates:
            anchor, axis = here.of(c.anchor), here.R @ c.axis
            here, twist = _moved(c, here, twist, anchor, axis)
            if c.kind == "free":
                twist = base_twist if link.parent is None else twist
            lines.append(Line(c, here.of(c.anchor), axis, here, twist))
        poses.pose[link.name], poses.twist[link.name], poses.lines[link.name] = here, twist, tuple(lines)
    return poses


def _moved(c: Coordinate, here: Pose, twist: Twist, anchor: Array, axis: Array) -> tuple[Pose, Twist]:
    if c.kind in ("free", "ball"):
        X = c.X_start or IDENTITY
        turned = X if c.kind == "free" else Pose(X.R, c.anchor - X.R @ c.anchor)
        return here @ turned, twist + _rate(c, here @ turned, anchor)
    way = (c.reference if c.position is None else c.position) - c.reference
    if way == 0 and c.velocity == 0:
        return here, twist
    if c.kind == "prismatic":
        return here @ screw(c.axis, c.anchor, 0.0, way), Twist(twist.w, twist.v + c.velocity * axis)
    motion = Twist(c.velocity * axis, c.velocity * crossed(anchor, axis))
    return here @ screw(c.axis, c.anchor, way, 0.0), twist + motion


def _rate(c: Coordinate, after: Pose, anchor: Array) -> Twist:
    """The motion of a free or ball joint: of a ball about its anchor, of a free link with the velocity of its origin."""
    w: Array = np.zeros(3) if c.w_start is None else after.R @ c.w_start
    if c.kind == "ball":
        return Twist(w, crossed(anchor, w))
    v = np.zeros(3) if c.v_start is None else c.v_start
    return Twist(w, v - crossed(w, after.p))


def mass_matrix(columns: Sequence[Array], bodies: Sequence[tuple[float, Array, Array]]) -> Array:
    """The inertia of all coordinates against each other at one pose: sum of m J_v^T J_v + J_w^T I J_w over the bodies.

    Args:
        columns: per body (6, n): angular over linear velocity [at its centre of mass] at a rate of 1 of each coordinate.
        bodies: mass [kg], centre of mass in W [m], inertia about it in W's axes [kg m2].
    Source: Featherstone, Rigid Body Dynamics Algorithms, section 6.1.
    """
    total = np.zeros((columns[0].shape[1],) * 2) if columns else np.zeros((0, 0))
    for J, (mass, _, inertia) in zip(columns, bodies, strict=True):
        total += mass * J[3:].T @ J[3:] + J[:3].T @ inertia @ J[:3]
    return total
