"""The negative controls of joints: what they hold, limits, springs and drives."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from harness.adapter import Feature
from harness.conformance.faults.broken_joints import (
    about_the_centre,
    in_the_child,
    misread_joints,
    misread_reactions,
    on_the_parent,
    reversed_rates,
    weightless,
    within_a_turn,
)
from harness.conformance.faults.broken_scenes import every_joint, stiffer, tied_to_centres
from harness.conformance.faults.broken_steps import CommandsFirstDriveOnly, DeafToUnknownJoints, joined
from harness.conformance.faults.control import Control
from harness.conformance.faults.plant import changed_scene, wrapped
from harness.scene import Distance, Joint, Prismatic, Revolute

__all__ = ["JOINT_CONTROLS"]

_TOLD = Feature.REVOLUTE | Feature.PRISMATIC | Feature.FIXED | Feature.SPRINGS | Feature.SPHERE
_D = Feature.PRISMATIC | Feature.DRIVES


def _without(attribute: str, **changed: float | None) -> Callable[[Any], Joint]:
    """A change of joints: the named fields of their drive or spring are replaced."""

    def change(joint: Any) -> Joint:
        law = getattr(joint, attribute, None)
        changed_joint: Joint = joint if law is None else replace(joint, **{attribute: replace(law, **changed)})
        return changed_joint

    return change


def _unlimited_motor(joint: Any) -> Joint:
    """A joint whose drive, where it has a constant force, has no limit."""
    drive = getattr(joint, "drive", None)
    changed: Joint = joint if drive is None or not drive.feedforward else replace(joint, drive=replace(drive, limit=None))
    return changed


JOINT_CONTROLS: tuple[Control, ...] = (
    Control(
        name="limits_dropped",
        fault="joint limits are ignored",
        plant=every_joint(lambda joint: replace(joint, limits=None)),
        caught_by=("limits_hold",),
        needs=Feature.REVOLUTE | Feature.LIMITS,
    ),
    Control(
        name="spring_ten_percent_stiff",
        fault="joint springs are 10 % too stiff",
        plant=every_joint(stiffer),
        caught_by=("spring_frequency",),
        needs=Feature.PRISMATIC | Feature.SPRINGS,
        applies_to_cases=("joint_spring",),
    ),
    Control(
        name="joined_bodies_collide",
        fault="bodies held by a joint collide all the same",
        plant=changed_scene(lambda scene: replace(scene, joints=tuple(replace(joint, collide=True) for joint in scene.joints))),
        caught_by=("joined_bodies_do_not_collide",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="joined_bodies_never_collide",
        fault="bodies held by a joint pass through each other although the joint lets them collide",
        plant=changed_scene(
            lambda scene: replace(scene, joints=tuple(replace(joint, collide=False) for joint in scene.joints))
        ),
        caught_by=("joined_bodies_collide_when_told",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="target_velocity_dropped",
        fault="the target velocity of a drive is lost",
        plant=joined(_without("drive", target_velocity=0.0)),
        caught_by=("target_velocity_acts",),
        needs=_D,
    ),
    Control(
        name="feedforward_dropped",
        fault="the constant force of a drive is lost",
        plant=joined(_without("drive", feedforward=None)),
        caught_by=("feedforward_acts", "motor_turns_two_bodies"),
        needs=_D | Feature.FEEDFORWARD | Feature.REVOLUTE,
    ),
    Control(
        name="feedforward_beyond_the_limit",
        fault="the constant force of a motor is not cut off",
        plant=joined(_unlimited_motor),
        caught_by=("feedforward_acts",),
        needs=_D | Feature.FEEDFORWARD,
    ),
    Control(
        name="command_reaches_the_first_drive",
        fault="a command reaches the first drive of the scene alone",
        plant=wrapped(CommandsFirstDriveOnly),
        caught_by=("command_reaches_every_drive",),
        needs=_D,
    ),
    Control(
        name="command_to_nobody",
        fault="a command to a joint without a drive is ignored",
        plant=wrapped(DeafToUnknownJoints),
        caught_by=("bad_targets_are_refused",),
        needs=_D,
    ),
    Control(
        name="drive_without_limit",
        fault="the force of a drive is not cut off",
        plant=joined(_without("drive", limit=None)),
        caught_by=("drive_force_is_limited",),
        needs=_D,
    ),
    Control(
        name="spring_rests_at_zero",
        fault="the rest of a spring is lost",
        plant=joined(_without("spring", rest=0.0)),
        caught_by=("spring_frequency",),
        needs=Feature.PRISMATIC | Feature.SPRINGS,
    ),
    Control(
        name="spring_without_damper",
        fault="the damper of a spring is lost",
        plant=joined(_without("spring", damping=0.0)),
        caught_by=("spring_frequency",),
        needs=Feature.PRISMATIC | Feature.SPRINGS,
    ),
    Control(
        name="coordinate_counted_from_zero",
        fault="a joint's coordinate starts at 0, whatever its position",
        plant=joined(lambda j: replace(j, position=0.0) if isinstance(j, Revolute | Prismatic) else j),
        caught_by=("limits_hold", "drive_reaches_its_target"),
        needs=_D | Feature.REVOLUTE | Feature.LIMITS,
    ),
    Control(
        name="axis_reversed",
        fault="joints turn and slide the other way",
        plant=joined(
            lambda j: (
                replace(j, axis_W=(-j.axis_W[0], -j.axis_W[1], -j.axis_W[2])) if isinstance(j, Revolute | Prismatic) else j
            )
        ),
        caught_by=("drive_reaches_its_target",),
        needs=_D | Feature.REVOLUTE,
    ),
    Control(
        name="joint_rates_reversed",
        fault="the rates of joints are told with the other sign",
        plant=misread_joints(reversed_rates),
        caught_by=("joint_states_agree_with_the_poses",),
        needs=_TOLD,
    ),
    Control(
        name="joint_angles_within_a_turn",
        fault="the angles of joints are told without their full turns",
        plant=misread_joints(within_a_turn),
        caught_by=("joint_states_agree_with_the_poses",),
        needs=_TOLD,
    ),
    Control(
        name="joint_reactions_on_the_parent",
        fault="the reactions of joints are told as they act on the parent",
        plant=misread_joints(on_the_parent),
        caught_by=("joint_reactions_bear_what_hangs", "joint_reactions_add_up_along_a_chain"),
        needs=_TOLD | Feature.BALL,
    ),
    Control(
        name="joint_reactions_in_the_child",
        fault="the reactions of joints are told in the frame of the child",
        plant=misread_reactions(in_the_child),
        caught_by=(
            "joint_reactions_bear_what_hangs",
            "joint_reactions_at_the_bottom_of_a_swing",
        ),
        needs=_TOLD,
    ),
    Control(
        name="joint_torques_about_the_centre",
        fault="the torques of joints are told about the centre of mass of the child",
        plant=misread_reactions(about_the_centre),
        caught_by=("joint_reactions_bear_what_hangs",),
        needs=_TOLD,
    ),
    Control(
        name="joint_reactions_without_weight",
        fault="the reactions of joints are told without the weight of the child",
        plant=misread_reactions(weightless),
        caught_by=(
            "joint_reactions_bear_what_hangs",
            "joint_reactions_at_the_bottom_of_a_swing",
            "joint_reactions_beside_contacts",
        ),
        needs=_TOLD,
    ),
    Control(
        name="rod_hung_elsewhere",
        fault="a rod is hung from another place",
        plant=changed_scene(
            lambda scene: replace(
                scene,
                joints=tuple(replace(j, anchor_W=(0.1, 0.1, 0.1)) if isinstance(j, Distance) else j for j in scene.joints),
            )
        ),
        caught_by=("distance_joint_keeps_its_length",),
        needs=Feature.DISTANCE,
    ),
    Control(
        name="distance_spring_rests_at_zero",
        fault="the rest of a spring between two bodies is lost",
        plant=joined(_without("spring", rest=0.0)),
        caught_by=("distance_spring_has_its_frequency", "distance_spring_holds_what_hangs"),
        needs=Feature.DISTANCE_SPRING,
    ),
    Control(
        name="distance_spring_without_damper",
        fault="the damper between two bodies is lost",
        plant=joined(_without("spring", damping=0.0)),
        caught_by=("distance_spring_has_its_frequency", "distance_spring_holds_what_hangs"),
        needs=Feature.DISTANCE_SPRING,
    ),
    Control(
        name="distance_spring_tied_to_the_centre",
        fault="a spring between two bodies pulls at the child's centre of mass",
        plant=changed_scene(tied_to_centres),
        caught_by=("distance_spring_pulls_where_it_is_tied",),
        needs=Feature.DISTANCE_SPRING,
    ),
)
"""Each on one engine that has what it needs."""
