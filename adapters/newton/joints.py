"""Joints: trees in the coordinates of Newton, and what closes loops beside them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from plumbline.adapters.newton.bodies import WORLD_BODY, Bodies, within
from plumbline.adapters.newton.damping import check_solver, dampen_free, damping_along
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import carried, refuse_speed_limit
from plumbline.harness.adapter.distance_springs import is_distance_spring
from plumbline.harness.adapter.joint_frames import joint_frames
from plumbline.harness.adapter.spanning_forest import spanning_forest
from plumbline.harness.scene import WORLD, Ball, Distance, Drive, Effect, Fixed, Joint, Prismatic, Revolute, Scene

UNBOUNDED = 1e10
"""A coordinate [rad or m] or an effort that nothing reaches; beyond it Newton takes a limit for none."""


@dataclass(frozen=True, slots=True)
class Aim:
    """What a drive asks of a coordinate that counts from the start. Terms: push: a constant force or torque."""

    position: float = 0.0
    rate: float = 0.0
    push: float = 0.0


@dataclass(frozen=True, slots=True)
class Driven:
    """A joint whose target may be arguments anew. Terms: number: Newton's. start: of its coordinate [rad or m]."""

    number: int
    drive: Drive
    start: float

    def aim(self, target: float) -> Aim:
        """What it asks where that is its target."""
        return aim_of(self.drive, target, self.start)


def aim_of(drive: Drive, target: float, start: float) -> Aim:
    """k (x0 - x) + c (u - x') + b with all that is constant as a shift of the target, or of the rate where k is 0."""
    k, c, push = drive.stiffness, drive.damping, drive.feedforward or 0.0
    if k > 0:
        return Aim(position=target - start + (c * drive.target_velocity + push) / k)
    if c > 0:
        return Aim(rate=drive.target_velocity + push / c)
    return Aim(push=push if drive.limit is None else max(-drive.limit, min(drive.limit, push)))


@dataclass(slots=True)
class Joints:
    """Puts joints into a model that is being made.

    Terms: softness: of limits and dry friction, by MuJoCo's attributes of a coordinate. solver: which will step the model.
    """

    bodies: Bodies
    solver: str
    softness: Mapping[str, Any]
    driven: dict[str, Driven] = field(default_factory=dict)
    numbers: dict[str, int] = field(default_factory=dict)

    def put(self) -> None:
        """Trees from what stands still or is led, then from what moves; then what closes loops. Raises: Unsupported."""
        scene = self.bodies.scene
        joints = [j for j in scene.joints if not is_distance_spring(j)] if Effect.JOINTS in scene.effects else []
        ground = [WORLD, *(body.name for body in scene.bodies if not body.movable)]
        check_solver(self.bodies, self.solver)
        for joint in joints:
            self._check(scene, joint)
        forest = spanning_forest(joints, lambda j: (j.parent, j.child), ground)
        placed = set[str]()
        for root in (*ground, *(body.name for body in scene.bodies if body.movable)):
            if root in placed:
                continue
            chain = []
            if self.bodies.links[root] != WORLD_BODY:
                chain.append(self.bodies.builder.add_joint_free(self.bodies.links[root], collision_filter_parent=False))
                dampen_free(self.bodies, self.bodies.scene.body(root), chain[0])
                placed.add(root)
            for branch in forest.depth_first(root):
                if branch.above == root and self.bodies.links[root] == WORLD_BODY and chain:
                    self.bodies.builder.add_articulation(chain)
                    chain = []
                chain.append(self._joint(branch.edge, branch.node))
                placed.add(branch.node)
            if chain:
                self.bodies.builder.add_articulation(chain)
        for joint in forest.closing:
            self._close(joint)

    def _check(self, scene: Scene, joint: Joint) -> None:
        """Raises: Unsupported."""
        ends = [name for name in (joint.parent, joint.child) if name != WORLD]
        touching = len(ends) == 2 and scene.collides(scene.body(ends[0]), scene.body(ends[1]))
        if joint.collide and touching:
            raise Unsupported(f"joint '{joint.name}'", "MuJoCo-Warp's own contacts let no body touch that which it hangs on")
        if isinstance(joint, Distance):
            raise Unsupported(f"joint '{joint.name}'", "Newton's solver over MuJoCo-Warp has no distance joint")
        if self.solver == "xpbd" and (laws := [law for law in carried(joint) if law != "limits"]):
            raise Unsupported(
                f"joint '{joint.name}': {laws[0]}",
                "XPBD, which alone of Newton's solvers here lets bodies rebound, makes the law anew in each iteration",
            )
        if isinstance(joint, Revolute | Prismatic):
            refuse_speed_limit(joint, "MuJoCo-Warp and XPBD bound no joint's rate")
            if joint.coupling is not None:
                raise Unsupported(f"joint '{joint.name}': coupling", "the adapter tells Newton no mimic joints")

    def _frames(self, joint: Joint, node: str) -> tuple[int, int, Any, Any]:
        """Newton's numbers of the body that a joint comes from and of that which it leads to, and its frames in them."""
        first = joint.parent if node == joint.child else joint.child
        frames = list(joint_frames(self.bodies.scene, joint, node))
        for k, name in enumerate((first, node)):
            if name != WORLD and self.bodies.links[name] == WORLD_BODY:
                frames[k] = within(self.bodies.scene.body(name), *frames[k])
        turned = [self.bodies.vendor.transform(*frame) for frame in frames]
        return self.bodies.links[first], self.bodies.links[node], turned[0], turned[1]

    def _joint(self, joint: Joint, node: str) -> int:
        """A joint of a tree, towards the body `node`."""
        parent, child, X_P, X_C = self._frames(joint, node)
        builder, held = self.bodies.builder, {"parent_xform": X_P, "child_xform": X_C, "collision_filter_parent": False}
        damping = damping_along(self.bodies, joint, node)
        match joint:
            case Fixed():
                number = builder.add_joint_fixed(parent, child, **held)
            case Ball():
                number = builder.add_joint_ball(parent, child, **held)
            case Revolute():
                number = builder.add_joint_revolute(parent, child, axis=(1.0, 0.0, 0.0), **held, **self._laws(joint, damping))
            case Prismatic():
                number = builder.add_joint_prismatic(parent, child, axis=(1.0, 0.0, 0.0), **held, **self._laws(joint, damping))
            case _:
                raise AssertionError(f"{joint.type} passed the door")
        self.numbers[joint.name] = int(number)
        if isinstance(joint, Revolute | Prismatic) and joint.drive is not None and Effect.DRIVES in self.bodies.scene.effects:
            self.driven[joint.name] = Driven(int(number), joint.drive, joint.position)
        return int(number)

    def _laws(self, joint: Revolute | Prismatic, damping: float) -> dict[str, Any]:
        """Limits, spring, drive, rotor and dry friction of a coordinate. Args: damping: of the body that hangs on it."""
        modes, arguments = self.bodies.vendor.newton.JointTargetMode, dict[str, Any]()
        arguments["armature"], arguments["friction"] = joint.armature or 0.0, joint.friction_loss or 0.0
        low, high = (None, None) if joint.limits is None else (joint.limits.lower, joint.limits.upper)
        arguments["limit_lower"] = -UNBOUNDED if low is None else low - joint.position
        arguments["limit_upper"] = UNBOUNDED if high is None else high - joint.position
        if self.softness:
            arguments["custom_attributes"] = self.softness
        arguments["damping"] = damping
        if joint.spring is not None:
            arguments["stiffness"], arguments["damping"] = joint.spring.stiffness, joint.spring.damping + damping
            arguments["rest_q"] = joint.spring.rest - joint.position
        arguments["actuator_mode"], arguments["effort_limit"] = modes.NONE, UNBOUNDED
        if joint.drive is not None and Effect.DRIVES in self.bodies.scene.effects:
            drive, aim = joint.drive, aim_of(joint.drive, joint.drive.target, joint.position)
            if drive.limit is not None:
                arguments["effort_limit"] = drive.limit
            if drive.stiffness > 0:
                arguments["actuator_mode"] = modes.POSITION
            elif drive.damping > 0:
                arguments["actuator_mode"] = modes.VELOCITY
            arguments["target_ke"], arguments["target_kd"] = drive.stiffness, drive.damping
            arguments["target_q"], arguments["target_qd"] = aim.position, aim.rate
        return arguments

    def _close(self, joint: Joint) -> None:
        """A joint that closes a loop, outside of every tree. Raises: Unsupported."""
        if self.solver != "mujoco":
            raise Unsupported(f"joint '{joint.name}' that closes a loop", "the adapter closes loops under MuJoCo-Warp alone")
        if isinstance(joint, Prismatic):
            raise Unsupported(f"joint '{joint.name}' that closes a loop", "MuJoCo closes loops by points and welds, not slides")
        laws = carried(joint)
        if laws:
            raise Unsupported(f"joint '{joint.name}' that closes a loop: {laws[0]}", "a loop's joint has no coordinate")
        node = joint.child if joint.child != WORLD and self.bodies.links[joint.child] != WORLD_BODY else joint.parent
        parent, child, X_P, X_C = self._frames(joint, node)
        builder, held = self.bodies.builder, {"parent_xform": X_P, "child_xform": X_C, "collision_filter_parent": False}
        match joint:
            case Fixed():
                builder.add_joint_fixed(parent, child, **held)
            case Ball():
                builder.add_joint_ball(parent, child, **held)
            case Revolute():
                builder.add_joint_revolute(parent, child, axis=(1.0, 0.0, 0.0), **held)
