"""The planted faults of rotors, dry friction, speed limits and couplings: what acts along joint coordinates."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from plumbline.harness.adapter import Feature
from plumbline.harness.scene import Prismatic, Revolute, Scene, Spring
from tests.planted_faults.fault import fault

_SLIDE = Feature.REVOLUTE | Feature.PRISMATIC
_SPEED = _SLIDE | Feature.SPEED_LIMIT | Feature.DRIVES | Feature.FEEDFORWARD


def _scaled(joint: Any, law: str, factor: float) -> Any:
    """A law of the joint times a factor; 0 drops it."""
    size = getattr(joint, law)
    return joint if size is None else replace(joint, **{law: factor * size})


def _tied(scene: Scene, change: Callable[[float], float]) -> Scene:
    """Every ratio is changed, and so is where its joint is said to start, so that the scene itself stays sound."""
    joints = {joint.name: joint for joint in scene.joints}
    positions = {joint.name: joint.position for joint in scene.joints if isinstance(joint, Revolute | Prismatic)}
    for joint in scene.joints:
        if isinstance(joint, Revolute | Prismatic) and joint.coupling is not None:
            ratio = change(joint.coupling.ratio)
            offset = joint.position - ratio * positions[joint.coupling.joint]
            joints[joint.name] = replace(joint, coupling=replace(joint.coupling, ratio=ratio, offset=offset))
    return replace(scene, joints=tuple(joints.values()))


@fault("armature_adds_inertia", "armature_acts_between_bodies", needs=_SLIDE | Feature.ARMATURE)
def armature_dropped(joint: Revolute | Prismatic) -> Any:
    """the rotors of joints are lost"""
    return _scaled(joint, "armature", 0.0)


@fault("armature_adds_inertia", "armature_acts_between_bodies", needs=_SLIDE | Feature.ARMATURE)
def armature_twenty_percent_off(joint: Revolute | Prismatic) -> Any:
    """rotors have 20 % too much inertia"""
    return _scaled(joint, "armature", 1.2)


@fault("armature_adds_inertia", needs=_SLIDE | Feature.ARMATURE)
def armature_has_weight(scene: Scene) -> Scene:
    """the rotor of a slide is taken for mass of what slides"""
    rotors = {j.child: j.armature for j in scene.joints if j.type == "prismatic" and j.armature}
    return replace(
        scene,
        bodies=tuple(replace(b, mass=b.mass + rotors.get(b.name, 0.0)) for b in scene.bodies),
        joints=tuple(replace(j, armature=None) if j.type == "prismatic" else j for j in scene.joints),
    )


@fault("armature_acts_between_bodies", needs=_SLIDE | Feature.ARMATURE)
def armature_of_the_child(scene: Scene) -> Scene:
    """the rotor of a hinge is taken for inertia of its child, and does not react on its parent"""
    rotors = {j.child: j.armature for j in scene.joints if j.type == "revolute" and j.armature}
    bodies = []
    for body in scene.bodies:
        (a, ab, ac), (_, b, bc), (_, _, c) = body.inertia
        more = rotors.get(body.name, 0.0)
        bodies.append(replace(body, inertia=((a + more, ab, ac), (ab, b + more, bc), (ac, bc, c + more))))
    joints = tuple(replace(j, armature=None) if j.type == "revolute" else j for j in scene.joints)
    return replace(scene, bodies=tuple(bodies), joints=joints)


@fault(
    "dry_friction_brakes",
    "dry_friction_holds",
    "dry_friction_beside_a_drive",
    needs=_SLIDE | Feature.FRICTION_LOSS | Feature.DRIVES,
)
def friction_loss_dropped(joint: Revolute | Prismatic) -> Any:
    """dry friction in joints is lost"""
    return _scaled(joint, "friction_loss", 0.0)


@fault(
    "dry_friction_brakes",
    "dry_friction_holds",
    "dry_friction_beside_a_drive",
    needs=_SLIDE | Feature.FRICTION_LOSS | Feature.DRIVES,
)
def friction_loss_twenty_percent_off(joint: Revolute | Prismatic) -> Any:
    """dry friction in joints is 20 % too weak"""
    return _scaled(joint, "friction_loss", 0.8)


@fault("dry_friction_brakes", "dry_friction_holds", needs=_SLIDE | Feature.FRICTION_LOSS | Feature.SPRINGS)
def friction_loss_as_a_damper(joint: Revolute | Prismatic) -> Any:
    """dry friction in a joint becomes a damper of as many N s/m or N m s/rad"""
    return replace(joint, friction_loss=None, spring=Spring(damping=joint.friction_loss or 0.0))


@fault("speed_limit_is_reached_and_kept", "speed_limit_reacts_on_both_bodies", needs=_SPEED)
def speed_limit_dropped(joint: Revolute | Prismatic) -> Any:
    """joints have no speed limit"""
    return replace(joint, speed_limit=None)


@fault("speed_limit_is_reached_and_kept", "speed_limit_reacts_on_both_bodies", needs=_SPEED)
def speed_limit_five_percent_off(joint: Revolute | Prismatic) -> Any:
    """speed limits of joints are 5 % too high"""
    return _scaled(joint, "speed_limit", 1.05)


@fault("speed_limit_is_reached_and_kept", needs=_SPEED | Feature.SPRINGS)
def speed_limit_as_a_damper(joint: Revolute | Prismatic) -> Any:
    """a speed limit becomes a damper under which the joint's motor comes to it in time"""
    if joint.speed_limit is None or joint.drive is None:
        return joint
    return replace(joint, speed_limit=None, spring=Spring(damping=abs(joint.drive.feedforward or 0.0) / joint.speed_limit))


@fault("speed_limit_reacts_on_both_bodies", needs=_SPEED)
def speed_limit_without_reaction(scene: Scene) -> Scene:
    """the parents of joints with speed limits feel nothing

    Those parents stand still.
    """
    parents = {j.parent for j in scene.joints if isinstance(j, Revolute | Prismatic) and j.speed_limit is not None}
    return replace(scene, bodies=tuple(replace(b, motion="static") if b.name in parents else b for b in scene.bodies))


@fault("coupled_coordinates_move_as_one", needs=_SLIDE | Feature.COUPLING)
def coupling_lost(joint: Revolute | Prismatic) -> Any:
    """coupled joints move freely"""
    return replace(joint, coupling=None)


@fault("coupled_coordinates_move_as_one", needs=_SLIDE | Feature.COUPLING)
def coupling_reversed(scene: Scene) -> Scene:
    """coupled joints move against each other where they should move alike"""
    return _tied(scene, lambda ratio: -ratio)


@fault("coupled_coordinates_move_as_one", needs=_SLIDE | Feature.COUPLING)
def coupling_ratio_lost(scene: Scene) -> Scene:
    """couplings have a ratio of 1"""
    return _tied(scene, lambda _: 1.0)


@fault("coupled_coordinates_move_as_one", needs=_SLIDE | Feature.COUPLING)
def coupling_inverted(scene: Scene) -> Scene:
    """the ratio of couplings is taken the other way round"""
    return _tied(scene, lambda ratio: 1.0 / ratio)
