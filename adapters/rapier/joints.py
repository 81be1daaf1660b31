"""Joints as impulse joints, with limits, and motors for springs, drives and dry friction."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from plumbline.adapters.rapier.vendor import pose
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import refuse_armature, refuse_speed_limit
from plumbline.harness.adapter.rotations import conjugate
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Drive,
    Effect,
    Fixed,
    Joint,
    Prismatic,
    Quaternion,
    Revolute,
    Scene,
    Spring,
    Vector3,
    multiply,
    rotate,
)

NEVER_REACHED = 1e6
"""A rate [rad/s or m/s] beyond all of a scene: a motor towards it gives all its force."""
OPEN = 3e38
"""A way [m] that single precision just holds."""
ROD = 1e9
"""Stiffness [N/m] of a rod: Rapier's joint between two points is a spring."""
RIGID = 1e9
"""Damping [N s/m or N m s/rad] over what a dry friction takes: it holds until the solver cuts it off."""


@dataclass(frozen=True, slots=True)
class Motor:
    """A law k (target - x) + c (rate - x'), cut off: what one motor of Rapier does. Terms: x counts from the start."""

    stiffness: float
    damping: float
    target: float
    rate: float
    limit: float | None = None


@dataclass(slots=True)
class DriveTold:
    """A drive whose target may be told anew. Terms: joint: of the world. axis: that turns or slides. position: at the start."""

    joint: Any
    axis: Any
    drive: Drive
    position: float
    turns: bool


def motors_of(joint: Revolute | Prismatic, effects: Effect) -> list[tuple[str, Motor]]:
    """The motors that a joint's laws take, each with its name."""
    made = []
    if joint.spring is not None:
        spring: Spring = joint.spring
        made.append(("spring", Motor(spring.stiffness, spring.damping, spring.rest - joint.position, 0.0)))
    if joint.drive is not None and Effect.DRIVES in effects:
        made.append(("drive", drive_motor(joint.drive, joint.drive.target, joint.position)))
    if joint.friction_loss:
        made.append(("friction", Motor(0.0, RIGID * joint.friction_loss, 0.0, 0.0, joint.friction_loss)))
    return made


def drive_motor(drive: Drive, target: float, position: float) -> Motor:
    """A drive as a motor; a feedforward b shifts its target by b/k, or its rate by b/c, or is all that it has."""
    k, c, push = drive.stiffness, drive.damping, drive.feedforward or 0.0
    if k > 0:
        return Motor(k, c, target - position + push / k, drive.target_velocity, drive.limit)
    if c > 0:
        return Motor(0.0, c, 0.0, drive.target_velocity + push / c, drive.limit)
    size = min(abs(push), math.inf if drive.limit is None else drive.limit)
    return Motor(0.0, abs(push), 0.0, math.copysign(NEVER_REACHED, push), size)


def put_joints(rapier: Any, scene: Scene, joints: Any, handles: dict[str, Any], insert: Any) -> Iterator[tuple[str, DriveTold]]:
    """Insert all joints of a scene; the drives by name. Args: insert: (parent, child, joint) to the joint in the world."""
    for joint in joints:
        if isinstance(joint, Distance):
            insert(handles[joint.parent], handles[joint.child], _line(rapier, scene, joint))
            continue
        insert_one = _generic(rapier, scene, joint)
        first = insert_one(_locked(rapier, joint))
        if isinstance(joint, Revolute | Prismatic):
            yield from _along(rapier, scene, joint, first, insert_one, handles, insert)
        else:
            insert(handles[joint.parent], handles[joint.child], first.build())


def _along(
    rapier: Any, scene: Scene, joint: Revolute | Prismatic, first: Any, frames: Any, handles: dict[str, Any], insert: Any
) -> Iterator[tuple[str, DriveTold]]:
    """A joint of one coordinate: its limits and its first motor on itself, each other motor on a joint that holds nothing."""
    refuse_armature(joint, "an impulse joint of Rapier has no inertia of its own")
    refuse_speed_limit(joint, "a joint of Rapier has no bound of its rate")
    if joint.coupling is not None:
        raise Unsupported(f"joint '{joint.name}': coupling to '{joint.coupling.joint}'", "Rapier ties no coordinates")
    axis = rapier.JointAxis.ANG_X if isinstance(joint, Revolute) else rapier.JointAxis.LIN_X
    if joint.limits is not None:
        first = first.limits(axis, *_range(joint))
    for number, (name, motor) in enumerate(motors_of(joint, scene.effects) or [("", None)]):
        made = first if number == 0 else frames(rapier.JointAxesMask.empty())
        if motor is not None:
            made = _with_motor(rapier, made, axis, motor, joint)
        placed = insert(handles[joint.parent], handles[joint.child], made.build())
        if name == "drive" and motor is not None and joint.drive is not None:
            yield joint.name, DriveTold(placed, axis, joint.drive, joint.position, isinstance(joint, Revolute))


def _with_motor(rapier: Any, made: Any, axis: Any, motor: Motor, joint: Revolute | Prismatic) -> Any:
    check_target(joint.name, isinstance(joint, Revolute) and motor.stiffness > 0, motor.target)
    made = made.motor_model(axis, rapier.MotorModel.FORCE_BASED)
    made = made.motor(axis, motor.target, motor.rate, motor.stiffness, motor.damping)
    return made if motor.limit is None else made.motor_max_force(axis, motor.limit)


def check_target(name: str, turns: bool, target: float) -> None:
    """Raises: Unsupported, for a target [rad] that the angle of an impulse joint does not reach."""
    if turns and abs(target) >= math.pi:
        raise Unsupported(
            f"joint '{name}': a spring or drive {target:.4g} rad from the start", "Rapier counts a joint's angle modulo a turn"
        )


def _range(joint: Revolute | Prismatic) -> tuple[float, float]:
    """The range from the start on. Raises: Unsupported."""
    assert joint.limits is not None
    lower, upper = (None if x is None else x - joint.position for x in (joint.limits.lower, joint.limits.upper))
    if isinstance(joint, Prismatic):
        return -OPEN if lower is None else lower, OPEN if upper is None else upper
    turn = 2 * math.pi - 1e-3
    low = lower if lower is not None else (upper or 0.0) - turn
    high = upper if upper is not None else low + turn
    if not (high - low <= turn and low > -turn and high < turn):
        raise Unsupported(f"joint '{joint.name}': limits", "Rapier counts a joint's angle modulo a turn")
    return low, high


def _locked(rapier: Any, joint: Joint) -> Any:
    kinds = {Fixed: "FIXED", Ball: "SPHERICAL", Revolute: "REVOLUTE", Prismatic: "PRISMATIC"}
    return getattr(rapier.JointAxesMask, f"LOCKED_{kinds[type(joint)]}_AXES")


def _generic(rapier: Any, scene: Scene, joint: Any) -> Any:
    """A function of the axes that are locked: a joint whose frames lie at the anchor, x along the axis.

    Where the anchor means nothing it is a centre of mass: with a lever of 5 m a slide's motor lacks 12 % of its force.
    """
    moved = joint.child if joint.child != WORLD and scene.body(joint.child).movable else joint.parent
    central = isinstance(joint, Fixed | Prismatic) and moved != WORLD
    anchor = scene.body(moved).p_WB if central else getattr(joint, "anchor_W", (0.0, 0.0, 0.0))
    q_WJ = _along_x(getattr(joint, "axis_W", (1.0, 0.0, 0.0)))
    ends = [_within(scene, name, anchor) for name in (joint.parent, joint.child)]
    frames = [pose(rapier, p, multiply(conjugate(q), q_WJ)) for p, q in ends]
    joined = frozenset((joint.parent, joint.child)) not in scene.joined()

    def made(locked: Any) -> Any:
        build = rapier.GenericJoint.builder(locked).local_frame1(frames[0]).local_frame2(frames[1])
        return build.contacts_enabled(joined)

    return made


def _line(rapier: Any, scene: Scene, joint: Distance) -> Any:
    """A rod, a rope or a spring between two points. Raises: Unsupported."""
    length = math.dist(joint.anchor_W, joint.child_anchor_W)
    if joint.limits is not None:
        if joint.limits.lower or joint.spring is not None or joint.limits.upper is None:
            raise Unsupported(f"distance joint '{joint.name}'", "Rapier bounds a distance from above alone, and not beside a spring")
        made = rapier.RopeJoint.builder(joint.limits.upper)
    elif joint.spring is not None:
        made = rapier.SpringJoint.builder(joint.spring.rest, joint.spring.stiffness, joint.spring.damping)
    else:
        made = rapier.SpringJoint.builder(length, ROD, 0.0)
    ends = ((joint.parent, joint.anchor_W), (joint.child, joint.child_anchor_W))
    (first, _), (second, _) = (_within(scene, name, point) for name, point in ends)
    made = made.local_anchor1(first).local_anchor2(second)
    return made.contacts_enabled(frozenset((joint.parent, joint.child)) not in scene.joined()).build()


def _within(scene: Scene, name: str, point_W: Vector3) -> tuple[Vector3, Quaternion]:
    """A point of W in the frame of a body, or of the world, and q_WB."""
    if name == WORLD:
        return point_W, (1.0, 0.0, 0.0, 0.0)
    body: Body = scene.body(name)
    x, y, z = (a - b for a, b in zip(point_W, body.p_WB, strict=True))
    return rotate(conjugate(body.q_WB), (x, y, z)), body.q_WB


def _along_x(axis: Vector3) -> Quaternion:
    """A rotation that turns x to the axis: by half a turn about the line midway between, of an axis that looks back its other end."""
    sign = 1.0 if axis[0] >= 0 else -1.0
    x, y, z = (sign * c for c in axis)
    long = math.hypot(1.0 + x, y, z)
    turn = (0.0, (1.0 + x) / long, y / long, z / long)
    return turn if sign > 0 else multiply(turn, (0.0, 0.0, 1.0, 0.0))
