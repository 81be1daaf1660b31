"""Joints as impulse joints, with limits, and motors for springs, drives and dry friction."""

import math
from dataclasses import dataclass, field
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
    """A drive whose target may be told anew.

    Terms: joint: its handle. axis: that turns or slides. position: at the start. wraps: is its angle counted modulo a turn?
    reduced: is it a joint of a multibody?
    """

    joint: Any
    axis: Any
    drive: Drive
    position: float
    wraps: bool
    reduced: bool


def motors_of(joint: Revolute | Prismatic, effects: Effect) -> list[tuple[str, Motor]]:
    """The motors that a joint's laws take, each with its name."""
    builder = []
    if joint.spring is not None:
        spring: Spring = joint.spring
        builder.append(("spring", Motor(spring.stiffness, spring.damping, spring.rest - joint.position, 0.0)))
    if joint.drive is not None and Effect.DRIVES in effects:
        builder.append(("drive", drive_motor(joint.drive, joint.drive.target, joint.position)))
    if joint.friction_loss:
        builder.append(("friction", Motor(0.0, RIGID * joint.friction_loss, 0.0, 0.0, joint.friction_loss)))
    return builder


def drive_motor(drive: Drive, target: float, position: float) -> Motor:
    """A drive as a motor; a feedforward b shifts its target by b/k, or its rate by b/c, or is all that it has."""
    k, c, push = drive.stiffness, drive.damping, drive.feedforward or 0.0
    if k > 0:
        return Motor(k, c, target - position + push / k, drive.target_velocity, drive.limit)
    if c > 0:
        return Motor(0.0, c, 0.0, drive.target_velocity + push / c, drive.limit)
    size = min(abs(push), math.inf if drive.limit is None else drive.limit)
    return Motor(0.0, abs(push), 0.0, math.copysign(NEVER_REACHED, push), size)


@dataclass(slots=True)
class Joiner:
    """Puts a scene's joints into a world. Terms: handles: of bodies by name. drives: what may be told anew."""

    rapier: Any
    world: Any
    scene: Scene
    handles: dict[str, Any]
    drives: dict[str, DriveTold] = field(default_factory=dict)

    def put(self, joint: Joint) -> None:
        """A joint between free bodies. Raises: Unsupported."""
        insert = self.world.impulse_joints.insert
        if isinstance(joint, Distance):
            insert(self.handles[joint.parent], self.handles[joint.child], _line(self.rapier, self.scene, joint))
        else:
            self._put(joint, joint.child, self.handles[joint.parent], insert, wraps=True)

    def link(self, joint: Joint, node: str, above: Any) -> Any:
        """A joint of a tree, towards the body `node`, in reduced coordinates. Raises: Unsupported."""
        parent = self.handles[joint.child if node == joint.parent else joint.parent] if above is None else above
        return self._put(joint, node, parent, self.world.multibody_joints.insert, wraps=False)

    def _put(self, joint: Any, node: str, parent: Any, insert: Any, wraps: bool) -> Any:
        """A joint towards a body with its limits and first motor; each other motor is on a joint that holds nothing."""
        rapier, child = self.rapier, self.handles[node]
        framed = _generic(rapier, self.scene, joint, node)
        held = framed(_locked(rapier, joint))
        if not isinstance(joint, Revolute | Prismatic):
            return insert(parent, child, held.build())
        refuse_armature(joint, "an impulse joint of Rapier has no inertia of its own")
        refuse_speed_limit(joint, "a joint of Rapier has no bound of its rate")
        if joint.coupling is not None:
            raise Unsupported(f"joint '{joint.name}': coupling to '{joint.coupling.joint}'", "Rapier ties no coordinates")
        turns = isinstance(joint, Revolute)
        axis = rapier.JointAxis.ANG_X if turns else rapier.JointAxis.LIN_X
        if joint.limits is not None:
            held = held.limits(axis, *_range(joint, wraps and turns))
        motors, inserted = motors_of(joint, self.scene.effects), None
        for number in range(max(1, len(motors))):
            first = number == 0
            builder = held if first else framed(rapier.JointAxesMask.empty())
            if motors:
                _, motor = motors[number]
                check_target(joint.name, turns and motor.stiffness > 0 and (wraps or not first), motor.target)
                builder = _with_motor(rapier, builder, axis, motor)
            placed = (insert if first else self.world.impulse_joints.insert)(parent, child, builder.build())
            inserted = inserted if inserted is not None else placed
            if motors and motors[number][0] == "drive" and joint.drive is not None:
                reduced = first and not wraps
                self.drives[joint.name] = DriveTold(placed, axis, joint.drive, joint.position, turns and not reduced, reduced)
        return inserted


def _with_motor(rapier: Any, builder: Any, axis: Any, motor: Motor) -> Any:
    builder = builder.motor_model(axis, rapier.MotorModel.FORCE_BASED)
    builder = builder.motor(axis, motor.target, motor.rate, motor.stiffness, motor.damping)
    return builder if motor.limit is None else builder.motor_max_force(axis, motor.limit)


def check_target(name: str, turns: bool, target: float) -> None:
    """Raises: Unsupported, for a target [rad] that the angle of an impulse joint does not reach."""
    if turns and abs(target) >= math.pi:
        raise Unsupported(
            f"joint '{name}': a spring or drive {target:.4g} rad from the start", "Rapier counts a joint's angle modulo a turn"
        )


def _range(joint: Revolute | Prismatic, wraps: bool) -> tuple[float, float]:
    """The range from the start on. Args: wraps: is the coordinate counted modulo a turn? Raises: Unsupported."""
    assert joint.limits is not None
    lower, upper = (None if x is None else x - joint.position for x in (joint.limits.lower, joint.limits.upper))
    if not wraps:
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


def _generic(rapier: Any, scene: Scene, joint: Any, node: str) -> Any:
    """A function of the axes that are locked: a joint towards `node` whose frames lie at the anchor, x along the axis.

    Towards the scene's parent the axis is turned about, which leaves the coordinate as it is.

    Where the anchor means nothing it is a centre of mass: with a lever of 5 m a slide's motor lacks 12 % of its force.
    """
    moved = joint.child if joint.child != WORLD and scene.body(joint.child).movable else joint.parent
    central = isinstance(joint, Fixed | Prismatic) and moved != WORLD
    anchor = scene.body(moved).p_WB if central else getattr(joint, "anchor_W", (0.0, 0.0, 0.0))
    x, y, z = getattr(joint, "axis_W", (1.0, 0.0, 0.0))
    away = node == joint.child
    q_WJ = _along_x((x, y, z) if away else (-x, -y, -z))
    ends = [_within(scene, name, anchor) for name in ((joint.parent, joint.child) if away else (joint.child, joint.parent))]
    frames = [pose(rapier, p, multiply(conjugate(q), q_WJ)) for p, q in ends]
    joined = frozenset((joint.parent, joint.child)) not in scene.joined()

    def builder(locked: Any) -> Any:
        build = rapier.GenericJoint.builder(locked).local_frame1(frames[0]).local_frame2(frames[1])
        return build.contacts_enabled(joined)

    return builder


def _line(rapier: Any, scene: Scene, joint: Distance) -> Any:
    """A rod, a rope or a spring between two points. Raises: Unsupported."""
    length = math.dist(joint.anchor_W, joint.child_anchor_W)
    if joint.limits is not None:
        if joint.limits.lower or joint.spring is not None or joint.limits.upper is None:
            raise Unsupported(
                f"distance joint '{joint.name}'", "Rapier bounds a distance from above alone, and not beside a spring"
            )
        builder = rapier.RopeJoint.builder(joint.limits.upper)
    elif joint.spring is not None:
        builder = rapier.SpringJoint.builder(joint.spring.rest, joint.spring.stiffness, joint.spring.damping)
    else:
        builder = rapier.SpringJoint.builder(length, ROD, 0.0)
    ends = ((joint.parent, joint.anchor_W), (joint.child, joint.child_anchor_W))
    (first, _), (second, _) = (_within(scene, name, point) for name, point in ends)
    builder = builder.local_anchor1(first).local_anchor2(second)
    return builder.contacts_enabled(frozenset((joint.parent, joint.child)) not in scene.joined()).build()


def _within(scene: Scene, name: str, point_W: Vector3) -> tuple[Vector3, Quaternion]:
    """A point of W in the frame of a body, or of the world, and q_WB."""
    if name == WORLD:
        return point_W, (1.0, 0.0, 0.0, 0.0)
    body: Body = scene.body(name)
    x, y, z = (a - b for a, b in zip(point_W, body.p_WB, strict=True))
    return rotate(conjugate(body.q_WB), (x, y, z)), body.q_WB


def _along_x(axis: Vector3) -> Quaternion:
    """A rotation that turns x to the axis: by half a turn about the line midway between x and that end which looks ahead."""
    sign = 1.0 if axis[0] >= 0 else -1.0
    x, y, z = (sign * c for c in axis)
    long = math.hypot(1.0 + x, y, z)
    turn = (0.0, (1.0 + x) / long, y / long, z / long)
    return turn if sign > 0 else multiply(turn, (0.0, 0.0, 1.0, 0.0))
