"""The negative controls of rotors, dry friction, speed limits and couplings: what acts along joint coordinates."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from harness.adapter import Adapter, Feature
from harness.conformance.faults.broken_scenes import every_joint
from harness.conformance.faults.control import Control
from harness.conformance.faults.plant import changed_scene
from harness.scene import Prismatic, Revolute, Scene, Spring

__all__ = ["COORDINATE_CONTROLS"]

_SLIDE = Feature.REVOLUTE | Feature.PRISMATIC
_SPEED = _SLIDE | Feature.SPEED_LIMIT | Feature.DRIVES | Feature.FEEDFORWARD


def _scaled(law: str, factor: float) -> Callable[[Adapter], Adapter]:
    """A law of every joint times a factor; 0 drops it."""

    def change(joint: Any) -> Any:
        size = getattr(joint, law)
        return joint if size is None else replace(joint, **{law: factor * size})

    return every_joint(change)


def _tied(change: Callable[[float], float]) -> Callable[[Adapter], Adapter]:
    """Every coupling is changed, and so is where its joint is said to start, so that the scene itself stays sound."""

    def apply(scene: Scene) -> Scene:
        joints = {joint.name: joint for joint in scene.joints}
        places = {joint.name: joint.position for joint in scene.joints if isinstance(joint, Revolute | Prismatic)}
        for joint in scene.joints:
            if isinstance(joint, Revolute | Prismatic) and joint.coupling is not None:
                ratio = change(joint.coupling.ratio)
                offset = joint.position - ratio * places[joint.coupling.joint]
                joints[joint.name] = replace(joint, coupling=replace(joint.coupling, ratio=ratio, offset=offset))
        return replace(scene, joints=tuple(joints.values()))

    return changed_scene(apply)


def _braked(joint: Any) -> Any:
    """A damper in the place of a speed limit: its motor's force over that speed."""
    if joint.speed_limit is None or joint.drive is None:
        return joint
    return replace(joint, speed_limit=None, spring=Spring(damping=abs(joint.drive.feedforward or 0.0) / joint.speed_limit))


def _anchored(scene: Scene) -> Scene:
    """The parents of joints with speed limits stand still, as if nothing reacted on them."""
    parents = {j.parent for j in scene.joints if isinstance(j, Revolute | Prismatic) and j.speed_limit is not None}
    return replace(scene, bodies=tuple(replace(b, motion="static") if b.name in parents else b for b in scene.bodies))


def _heavier(scene: Scene) -> Scene:
    """A rotor's inertia becomes mass of the child, which has weight."""
    rotors = {j.child: j.armature for j in scene.joints if j.type == "prismatic" and j.armature}
    return replace(
        scene,
        bodies=tuple(replace(b, mass=b.mass + rotors.get(b.name, 0.0)) for b in scene.bodies),
        joints=tuple(replace(j, armature=None) if j.type == "prismatic" else j for j in scene.joints),
    )


def _turned_with_child(scene: Scene) -> Scene:
    """A rotor's inertia becomes the child's, whatever its parent does."""
    rotors = {j.child: j.armature for j in scene.joints if j.type == "revolute" and j.armature}
    bodies = []
    for body in scene.bodies:
        (a, ab, ac), (_, b, bc), (_, _, c) = body.inertia
        more = rotors.get(body.name, 0.0)
        bodies.append(replace(body, inertia=((a + more, ab, ac), (ab, b + more, bc), (ac, bc, c + more))))
    joints = tuple(replace(j, armature=None) if j.type == "revolute" else j for j in scene.joints)
    return replace(scene, bodies=tuple(bodies), joints=joints)


COORDINATE_CONTROLS: tuple[Control, ...] = (
    Control(
        name="armature_dropped",
        fault="the rotors of joints are lost",
        plant=_scaled("armature", 0.0),
        caught_by=("armature_adds_inertia", "armature_acts_between_bodies"),
        needs=_SLIDE | Feature.ARMATURE,
    ),
    Control(
        name="armature_twenty_percent_off",
        fault="rotors have 20 % too much inertia",
        plant=_scaled("armature", 1.2),
        caught_by=("armature_adds_inertia", "armature_acts_between_bodies"),
        needs=_SLIDE | Feature.ARMATURE,
    ),
    Control(
        name="armature_has_weight",
        fault="the rotor of a slide is taken for mass of what slides",
        plant=changed_scene(_heavier),
        caught_by=("armature_adds_inertia",),
        needs=_SLIDE | Feature.ARMATURE,
    ),
    Control(
        name="armature_of_the_child",
        fault="the rotor of a hinge is taken for inertia of its child, and does not react on its parent",
        plant=changed_scene(_turned_with_child),
        caught_by=("armature_acts_between_bodies",),
        needs=_SLIDE | Feature.ARMATURE,
    ),
    Control(
        name="friction_loss_dropped",
        fault="dry friction in joints is lost",
        plant=_scaled("friction_loss", 0.0),
        caught_by=("dry_friction_brakes", "dry_friction_holds", "dry_friction_beside_a_drive"),
        needs=_SLIDE | Feature.FRICTION_LOSS | Feature.DRIVES,
    ),
    Control(
        name="friction_loss_twenty_percent_off",
        fault="dry friction in joints is 20 % too weak",
        plant=_scaled("friction_loss", 0.8),
        caught_by=("dry_friction_brakes", "dry_friction_holds", "dry_friction_beside_a_drive"),
        needs=_SLIDE | Feature.FRICTION_LOSS | Feature.DRIVES,
    ),
    Control(
        name="friction_loss_as_a_damper",
        fault="dry friction in a joint becomes a damper of as many N s/m or N m s/rad",
        plant=every_joint(lambda joint: replace(joint, friction_loss=None, spring=Spring(damping=joint.friction_loss or 0.0))),
        caught_by=("dry_friction_brakes", "dry_friction_holds"),
        needs=_SLIDE | Feature.FRICTION_LOSS | Feature.SPRINGS,
    ),
    Control(
        name="speed_limit_dropped",
        fault="joints have no speed limit",
        plant=every_joint(lambda joint: replace(joint, speed_limit=None)),
        caught_by=("speed_limit_is_reached_and_kept", "speed_limit_reacts_on_both_bodies"),
        needs=_SPEED,
    ),
    Control(
        name="speed_limit_five_percent_off",
        fault="speed limits of joints are 5 % too high",
        plant=_scaled("speed_limit", 1.05),
        caught_by=("speed_limit_is_reached_and_kept", "speed_limit_reacts_on_both_bodies"),
        needs=_SPEED,
    ),
    Control(
        name="speed_limit_as_a_damper",
        fault="a speed limit becomes a damper under which the joint's motor comes to it in time",
        plant=every_joint(_braked),
        caught_by=("speed_limit_is_reached_and_kept",),
        needs=_SPEED | Feature.SPRINGS,
    ),
    Control(
        name="speed_limit_without_reaction",
        fault="the parents of joints with speed limits feel nothing",
        plant=changed_scene(_anchored),
        caught_by=("speed_limit_reacts_on_both_bodies",),
        needs=_SPEED,
    ),
    Control(
        name="coupling_lost",
        fault="coupled joints move freely",
        plant=every_joint(lambda joint: replace(joint, coupling=None)),
        caught_by=("coupled_coordinates_move_as_one",),
        needs=_SLIDE | Feature.COUPLING,
    ),
    Control(
        name="coupling_reversed",
        fault="coupled joints move against each other where they should move alike",
        plant=_tied(lambda ratio: -ratio),
        caught_by=("coupled_coordinates_move_as_one",),
        needs=_SLIDE | Feature.COUPLING,
    ),
    Control(
        name="coupling_ratio_lost",
        fault="couplings have a ratio of 1",
        plant=_tied(lambda _: 1.0),
        caught_by=("coupled_coordinates_move_as_one",),
        needs=_SLIDE | Feature.COUPLING,
    ),
    Control(
        name="coupling_inverted",
        fault="the ratio of couplings is taken the other way round",
        plant=_tied(lambda ratio: 1.0 / ratio),
        caught_by=("coupled_coordinates_move_as_one",),
        needs=_SLIDE | Feature.COUPLING,
    ),
)
"""Each on one engine that has what it needs."""
