"""Joints: trees of them as articulations in reduced coordinates, all others as constraints between two bodies."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plumbline.adapters.sapien.vendor import pose
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.carried_laws import carried, refuse_armature, refuse_speed_limit
from plumbline.harness.adapter.joint_frames import joint_frames, within
from plumbline.harness.adapter.motors import Motor, drive_motor, motors_of
from plumbline.harness.adapter.reduced_trees import JointTree
from plumbline.harness.scene import WORLD, Ball, Distance, Drive, Effect, Fixed, Joint, Prismatic, Revolute, Scene, Spring
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.joint_states import joint_states

_FREE = 1e6
"""A rate [rad/s or m/s] that nothing reaches."""
_INFINITE = 3e38
_FURTHER = 1.0
"""How far along the axis [m] the second point of a hinge, slide or weld is held. Below .1 m single precision shows."""


@dataclass(slots=True)
class Driven:
    """A joint whose target may be told anew. Terms: position: of its coordinate at the start [rad or m]."""

    joint: Any
    drive: Drive
    spring: Spring | None
    position: float

    def aim(self, target: float) -> None:
        """Tell it another target [rad or m]."""
        motor = one_motor(drive_motor(self.drive, target, self.position), self.spring, self.position)
        self.joint.set_drive_target(motor.target)
        self.joint.set_drive_velocity_target(motor.rate)


def one_motor(drive: Motor | None, spring: Spring | None, position: float) -> Motor:
    """A drive and a spring as the one drive that a joint of PhysX has."""
    if spring is None:
        return drive or Motor("drive", 0.0, 0.0, 0.0, 0.0)
    k, c = spring.stiffness, spring.damping
    rest = spring.rest - position
    if drive is None:
        return Motor("spring", k, c, rest, 0.0)
    stiff, damped = k + drive.stiffness, c + drive.damping
    push = k * rest + drive.stiffness * drive.target + drive.damping * drive.rate
    if stiff > 0:
        return Motor("drive", stiff, damped, push / stiff, 0.0)
    return Motor("drive", 0.0, damped, 0.0, push / damped if damped > 0 else 0.0)


@dataclass(slots=True)
class Articulated:
    """Makes articulations. Terms: link: (body's name, component) to an entity with the body's mass and shapes."""

    sapien: Any
    scene: Scene
    capped: bool
    link: Callable[[str, Any], Any]
    driven: dict[str, Driven] = field(default_factory=dict)

    def put(self, world: Any, tree: JointTree) -> dict[str, Any]:
        """The links of a tree by the names of their bodies, with the velocities of the start. Raises: Unsupported."""
        component, scene = self.sapien.physx.PhysxArticulationLinkComponent, self.scene
        still = tree.root == WORLD or scene.body(tree.root).motion == "static"
        root = component(None)
        links, entities = {tree.root: root}, []
        if still:
            entity = self.sapien.Entity()
            entity.add_component(root)
            if tree.root != WORLD:
                body = scene.body(tree.root)
                entity.pose = pose(self.sapien, body.p_WB, body.q_WB)
            entities.append(entity)
        else:
            entities.append(self.link(tree.root, root))
        root.joint.type = "fixed" if still else "undefined"
        for branch in tree.branches:
            links[branch.node] = component(links[branch.above])
            entities.append(self.link(branch.node, links[branch.node]))
            self._tell(links[branch.node].joint, branch.edge, branch.node)
        for entity in entities:
            world.add_entity(entity)
        self._set_rates(root.articulation, tree, still)
        if still:
            del links[tree.root]
        return links

    def _tell(self, link_joint: Any, joint: Any, node: str) -> None:
        """Frames, limits, rotor, bound of the rate and drive of a link's joint. Raises: Unsupported."""
        first, second = joint_frames(self.scene, joint, node)
        link_joint.type = {Fixed: "fixed", Revolute: "revolute_unwrapped", Prismatic: "prismatic"}[type(joint)]
        link_joint.pose_in_parent, link_joint.pose_in_child = pose(self.sapien, *first), pose(self.sapien, *second)
        if joint.collide:
            raise Unsupported(f"joint '{joint.name}'", "neighbours in an articulation of PhysX do not touch")
        if isinstance(joint, Fixed):
            return
        check_laws(joint)
        low, high = (None, None) if joint.limits is None else (joint.limits.lower, joint.limits.upper)
        ends = -np.inf if low is None else low - joint.position, np.inf if high is None else high - joint.position
        link_joint.limit = np.array([ends], dtype=np.float32)
        link_joint.set_friction(0.0)
        link_joint.set_armature(np.array([joint.armature or 0.0], dtype=np.float32))
        if joint.speed_limit is not None:
            link_joint.max_velocity = joint.speed_limit
        elif not self.capped:
            link_joint.max_velocity = _FREE
        driven = joint.drive is not None and Effect.DRIVES in self.scene.effects
        drive = drive_motor(joint.drive, joint.drive.target, joint.position) if driven else None
        if joint.spring is not None and drive is not None and drive.limit is not None:
            raise Unsupported(f"joint '{joint.name}': a spring beside a drive with a limit", "a joint of PhysX has one drive")
        if joint.friction_loss and (joint.spring is not None or drive is not None):
            raise Unsupported(f"joint '{joint.name}': friction_loss beside a spring or drive", "a joint of PhysX has one drive")
        (motor,) = motors_of(joint, Effect.JOINTS) if joint.friction_loss else (one_motor(drive, joint.spring, joint.position),)
        link_joint.set_drive_property(
            motor.stiffness, motor.damping, _INFINITE if motor.limit is None else motor.limit, "force"
        )
        link_joint.set_drive_target(motor.target)
        link_joint.set_drive_velocity_target(motor.rate)
        if driven:
            self.driven[joint.name] = Driven(link_joint, joint.drive, joint.spring, joint.position)

    def _set_rates(self, articulation: Any, tree: JointTree, still: bool) -> None:
        scene, start = self.scene, State.initial(self.scene)
        rate = dict(zip((joint.name for joint in scene.joints), joint_states(scene, start).rate.tolist(), strict=True))
        if not still:
            number = scene.index(tree.root)
            articulation.set_root_linear_velocity(start.v_WB[number].tolist())
            articulation.set_root_angular_velocity(start.w_WB[number].tolist())
        by_name = {joint.child_link.entity.name: joint for joint in articulation.active_joints}
        order = {name: k for k, name in enumerate(by_name)}
        rates = np.zeros(articulation.dof, dtype=np.float32)
        for branch in tree.branches:
            name = str(scene.index(branch.node))
            if name in order:
                rates[order[name]] = rate[branch.edge.name]
        if len(rates):
            articulation.set_qvel(rates)


def check_laws(joint: Revolute | Prismatic) -> None:
    """Raises: Unsupported, for laws that no joint of SAPIEN has."""
    if joint.coupling is not None:
        raise Unsupported(
            f"joint '{joint.name}': coupling to '{joint.coupling.joint}'",
            "SAPIEN ties two hinges by a gear and the joints of an articulation by a spring",
        )


def constrain(sapien: Any, scene: Scene, joint: Joint, bodies: Mapping[str, Any], child: Any) -> list[Any]:
    """The components of a joint that is a constraint of the body `child`. Raises: Unsupported."""
    physx = sapien.physx
    if joint.collide and frozenset((joint.parent, joint.child)) not in scene.joined() and _touch(scene, joint):
        raise Unsupported(f"joint '{joint.name}'", "bodies that a joint of SAPIEN holds do not touch")
    node = joint.child if bodies.get(joint.child) is child else joint.parent
    other = bodies.get(joint.parent if node == joint.child else joint.child)
    if isinstance(joint, Distance):
        constraint = physx.PhysxDistanceJointComponent(child)
        points = {joint.parent: joint.anchor_W, joint.child: joint.child_anchor_W}
        names = (joint.parent, joint.child) if node == joint.child else (joint.child, joint.parent)
        frames = [pose(sapien, within(scene, name, points[name]), (1.0, 0.0, 0.0, 0.0)) for name in names]
        _bound(constraint, joint)
    else:
        constraint = physx.PhysxDriveComponent(child)
        frames = [pose(sapien, *frame) for frame in joint_frames(scene, joint, node)]
        _lock(constraint, joint)
    held = [(constraint, frames)]
    if not isinstance(joint, Distance | Ball):
        # SAPIEN's limits of swing do nothing, so what a joint leaves no swing is held at a second point of its axis.
        further, along = physx.PhysxDriveComponent(child), sapien.Pose([_FURTHER, 0.0, 0.0])
        further.set_limit_y(0.0, 0.0)
        further.set_limit_z(0.0, 0.0)
        held.append((further, [frame * along for frame in frames]))
    for component, ends in held:
        if other is not None:
            component.parent = other
        component.pose_in_parent, component.pose_in_child = ends
    return [component for component, _ in held]


def _touch(scene: Scene, joint: Joint) -> bool:
    ends = [name for name in (joint.parent, joint.child) if name != WORLD]
    return len(ends) == 2 and scene.collides(scene.body(ends[0]), scene.body(ends[1]))


def _bound(constraint: Any, joint: Distance) -> None:
    """A rod or a range. Raises: Unsupported."""
    if joint.spring is not None:
        raise Unsupported(
            f"distance joint '{joint.name}'",
            "limits of a distance joint of PhysX are hard or a spring, and the adapter makes one",
        )
    length = math.dist(joint.anchor_W, joint.child_anchor_W)
    if joint.limits is not None:
        upper = joint.limits.upper
        constraint.set_limit(joint.limits.lower or 0.0, _INFINITE if upper is None else upper)
    else:
        constraint.set_limit(length, length)


def _lock(constraint: Any, joint: Any) -> None:
    """Lock what a joint does not leave free, but for swing. Raises: Unsupported."""
    laws = [law for law in carried(joint) if law != "limits"]
    if isinstance(joint, Revolute | Prismatic):
        refuse_armature(joint, "a joint between free bodies has no inertia of its own")
        refuse_speed_limit(joint, "a joint between free bodies has no bound of its rate")
        check_laws(joint)
    if laws:
        raise Unsupported(
            f"joint '{joint.name}': {laws[0]}",
            "drives of SAPIEN's constraints exceed their law under TGS, and limit an impulse; joints in trees have it",
        )
    low, high = (None, None)
    if getattr(joint, "limits", None) is not None:
        low, high = joint.limits.lower, joint.limits.upper
    ends = -np.inf if low is None else low - joint.position, np.inf if high is None else high - joint.position
    if not isinstance(joint, Prismatic):
        constraint.set_limit_x(0.0, 0.0)
    elif joint.limits is not None:
        constraint.set_limit_x(*ends)
    constraint.set_limit_y(0.0, 0.0)
    constraint.set_limit_z(0.0, 0.0)
    if isinstance(joint, Ball):
        return
    if not isinstance(joint, Revolute):
        constraint.set_limit_twist(0.0, 0.0)
    elif joint.limits is not None:
        if not max(map(abs, ends)) < math.pi:
            raise Unsupported(
                f"joint '{joint.name}': limits", "a stop of a constraint of PhysX beyond half a turn holds nothing"
            )
        constraint.set_limit_twist(*ends)


def holder(scene: Scene, joint: Joint) -> str:
    """The name of the body whose component a constraint is: the child, unless only the parent moves."""
    movable = [name for name in (joint.child, joint.parent) if name != WORLD and scene.body(name).movable]
    return movable[0] if movable else joint.child
