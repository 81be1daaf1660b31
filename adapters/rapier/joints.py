"""Joints as impulse joints, with limits, and motors for springs, drives and dry friction."""

import math
from dataclasses import dataclass, field
from typing import Any

from plumbline.adapters.rapier.vendor import pose
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import carried, refuse_armature, refuse_speed_limit
from plumbline.harness.adapter.joint_frames import joint_frames, within
from plumbline.harness.adapter.motors import Motor, motors_of
from plumbline.harness.scene import (
    Ball,
    Distance,
    Drive,
    Effect,
    Fixed,
    Joint,
    Prismatic,
    Revolute,
    Scene,
)

OPEN = 3e38
"""A way [m] that single precision just holds."""
GAP = 0.25
"""Between the stops of a hinge that counts its angle modulo a turn [rad]: who passes it in a step is pulled to the other."""
ROD = 1e9
"""Stiffness [N/m] of a rod: Rapier's joint between two points is a spring."""


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
        beside = self.handles.get(joint.child if node == joint.parent else joint.parent)
        placed = self._put(joint, node, beside if above is None else above, self.world.multibody_joints.insert, wraps=False)
        if above not in (None, beside) and beside is not None and not joint.collide:  # of a body that another stands for
            free = _generic(self.rapier, self.scene, joint, node)(self.rapier.JointAxesMask.empty())
            self.world.impulse_joints.insert(beside, self.handles[node], free.build())
        return placed

    def _put(self, joint: Any, node: str, parent: Any, insert: Any, wraps: bool) -> Any:
        """A joint towards a body with its limits and first motor; each other motor is on a joint that holds nothing."""
        rapier, child = self.rapier, self.handles[node]
        framed = _generic(rapier, self.scene, joint, node)
        held = framed(_locked(rapier, joint))
        if not isinstance(joint, Revolute | Prismatic):
            return insert(parent, child, held.build())
        if wraps:
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
                motor = motors[number]
                check_target(joint.name, turns and motor.stiffness > 0 and (wraps or not first), motor.target)
                builder = _with_motor(rapier, builder, axis, motor)
            placed = (insert if first else self.world.impulse_joints.insert)(parent, child, builder.build())
            inserted = inserted if inserted is not None else placed
            if motors and motors[number].law == "drive" and joint.drive is not None:
                reduced = first and not wraps
                self.drives[joint.name] = DriveTold(placed, axis, joint.drive, joint.position, turns and not reduced, reduced)
        return inserted


def _with_motor(rapier: Any, builder: Any, axis: Any, motor: Motor) -> Any:
    builder = builder.motor_model(axis, rapier.MotorModel.FORCE_BASED)
    builder = builder.motor(axis, motor.target, motor.rate, motor.stiffness, motor.damping)
    return builder if motor.limit is None else builder.motor_max_force(axis, motor.limit)


def of_reduced_alone(joint: Joint, effects: Effect) -> bool:
    """Does Rapier have it in reduced coordinates alone? It has a rotor, one limit, or limits or a target beyond a turn."""
    if "armature" in carried(joint):
        return True
    if not isinstance(joint, Revolute):
        return False
    if joint.limits is not None and (joint.limits.lower is None) != (joint.limits.upper is None):
        return True
    try:
        for motor in motors_of(joint, effects):
            check_target(joint.name, motor.stiffness > 0, motor.target)
        if joint.limits is not None:
            _range(joint, True)
    except Unsupported:
        return True
    return False


def check_target(name: str, turns: bool, target: float) -> None:
    """Raises: Unsupported, for a target [rad] that the angle of an impulse joint does not reach."""
    if turns and abs(target) >= math.pi:
        raise Unsupported(
            f"joint '{name}': a spring or drive {target:.4g} rad from the start",
            "an impulse joint of Rapier counts its angle modulo a turn",
        )


def _range(joint: Revolute | Prismatic, wraps: bool) -> tuple[float, float]:
    """The range from the start on. Args: wraps: is the coordinate counted modulo a turn? Raises: Unsupported."""
    assert joint.limits is not None
    lower, upper = (None if x is None else x - joint.position for x in (joint.limits.lower, joint.limits.upper))
    if not wraps:
        return -OPEN if lower is None else lower, OPEN if upper is None else upper
    turn = 2 * math.pi - GAP
    low = lower if lower is not None else (upper or 0.0) - turn
    high = upper if upper is not None else low + turn
    if not (high - low <= turn and low > -turn and high < turn):
        raise Unsupported(f"joint '{joint.name}': limits", "an impulse joint of Rapier counts its angle modulo a turn")
    return low, high


def _locked(rapier: Any, joint: Joint) -> Any:
    kinds = {Fixed: "FIXED", Ball: "SPHERICAL", Revolute: "REVOLUTE", Prismatic: "PRISMATIC"}
    return getattr(rapier.JointAxesMask, f"LOCKED_{kinds[type(joint)]}_AXES")


def _generic(rapier: Any, scene: Scene, joint: Any, node: str) -> Any:
    """A function of the axes that are locked: a joint towards `node`, x along its axis."""
    first, second = (pose(rapier, p, q) for p, q in joint_frames(scene, joint, node))
    joined = frozenset((joint.parent, joint.child)) not in scene.joined()
    return lambda locked: rapier.GenericJoint.builder(locked).local_frame1(first).local_frame2(second).contacts_enabled(joined)


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
    first, second = (within(scene, name, point) for name, point in ends)
    builder = builder.local_anchor1(first).local_anchor2(second)
    return builder.contacts_enabled(frozenset((joint.parent, joint.child)) not in scene.joined()).build()
