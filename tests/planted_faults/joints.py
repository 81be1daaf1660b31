"""The planted faults of joints: what they hold, limits, springs and drives, and what an engine tells of them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.scene import WORLD, Distance, Joint, Limits, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.joint_states import JointStates
from plumbline.harness.trajectory.kinematics import rotate, rotate_back
from tests.planted_faults.fault import fault
from tests.planted_faults.planting import Wrapped

_TOLD = Feature.REVOLUTE | Feature.PRISMATIC | Feature.FIXED | Feature.SPRINGS | Feature.SPHERE
_D = Feature.PRISMATIC | Feature.DRIVES


def _replaced(joint: Any, law: str, **fields: float | None) -> Any:
    """The joint with some fields of its drive or spring replaced, where it has one."""
    present = getattr(joint, law, None)
    return joint if present is None else replace(joint, **{law: replace(present, **fields)})


class _Misread(Wrapped):
    """What the engine tells of joints is changed."""

    def joint_states(self) -> JointStates:
        return self.changed(self.inner.joint_states())

    def changed(self, states: JointStates) -> JointStates:
        return replace(states, reaction=self.reaction(states.reaction))

    def reaction(self, reaction: Floats) -> Floats:
        """Forces and torques (j, 6) of the joints, changed."""
        return reaction


@fault("one_limit_leaves_the_other_side_open", needs=Feature.REVOLUTE | Feature.PRISMATIC | Feature.LIMITS)
def open_limits_at_one(joint: Revolute | Prismatic) -> Joint:
    """a limit that is left open is taken for one at 1 m or rad"""
    if joint.limits is None:
        return joint
    lower, upper = joint.limits.lower, joint.limits.upper
    return replace(joint, limits=Limits(lower=-1.0 if lower is None else lower, upper=1.0 if upper is None else upper))


@fault("limits_hold", needs=Feature.REVOLUTE | Feature.LIMITS)
def limits_dropped(joint: Revolute | Prismatic) -> Joint:
    """joint limits are ignored"""
    return replace(joint, limits=None)


@fault("spring_frequency", needs=Feature.PRISMATIC | Feature.SPRINGS, cases=("joint_spring",))
def spring_ten_percent_stiff(joint: Revolute | Prismatic) -> Joint:
    """joint springs are 10 % too stiff"""
    return joint if joint.spring is None else _replaced(joint, "spring", stiffness=1.1 * joint.spring.stiffness)


@fault("joined_bodies_do_not_collide", needs=Feature.REVOLUTE | Feature.BOX)
def joined_bodies_collide(joint: Joint) -> Joint:
    """bodies held by a joint collide all the same"""
    return replace(joint, collide=True)


@fault("joined_bodies_collide_when_told", needs=Feature.REVOLUTE | Feature.BOX)
def joined_bodies_never_collide(joint: Joint) -> Joint:
    """bodies held by a joint pass through each other although the joint lets them collide"""
    return replace(joint, collide=False)


@fault("target_velocity_acts", needs=_D)
def target_velocity_dropped(joint: Joint) -> Joint:
    """the target velocity of a drive is lost"""
    return _replaced(joint, "drive", target_velocity=0.0)


@fault("feedforward_acts", "motor_turns_two_bodies", needs=_D | Feature.FEEDFORWARD | Feature.REVOLUTE)
def feedforward_dropped(joint: Joint) -> Joint:
    """the constant force of a drive is lost"""
    return _replaced(joint, "drive", feedforward=None)


@fault("feedforward_acts", needs=_D | Feature.FEEDFORWARD)
def feedforward_beyond_the_limit(joint: Joint) -> Joint:
    """the constant force of a motor is not cut off"""
    drive = getattr(joint, "drive", None)
    return joint if drive is None or not drive.feedforward else replace(joint, drive=replace(drive, limit=None))


@fault("command_reaches_every_drive", needs=_D)
class command_reaches_the_first_drive(Wrapped):
    """a command reaches the first drive of the scene alone"""

    def command(self, targets: Mapping[str, float]) -> None:
        driven = [joint.name for joint in self.scene.joints if getattr(joint, "drive", None) is not None]
        self.inner.command({name: target for name, target in targets.items() if name in driven[:1]})


@fault("bad_targets_are_refused", needs=_D)
class command_to_nobody(Wrapped):
    """a command to a joint without a drive is ignored"""

    def command(self, targets: Mapping[str, float]) -> None:
        driven = {joint.name for joint in self.scene.joints if getattr(joint, "drive", None) is not None}
        self.inner.command({name: target for name, target in targets.items() if name in driven})


@fault("drive_force_is_limited", needs=_D)
def drive_without_limit(joint: Joint) -> Joint:
    """the force of a drive is not cut off"""
    return _replaced(joint, "drive", limit=None)


@fault("spring_frequency", needs=Feature.PRISMATIC | Feature.SPRINGS)
def spring_rests_at_zero(joint: Joint) -> Joint:
    """the rest of a spring is lost"""
    return _replaced(joint, "spring", rest=0.0)


@fault("spring_frequency", needs=Feature.PRISMATIC | Feature.SPRINGS)
def spring_without_damper(joint: Joint) -> Joint:
    """the damper of a spring is lost"""
    return _replaced(joint, "spring", damping=0.0)


@fault("limits_hold", "drive_reaches_its_target", needs=_D | Feature.REVOLUTE | Feature.LIMITS)
def coordinate_counted_from_zero(joint: Revolute | Prismatic) -> Joint:
    """a joint's coordinate starts at 0, whatever its position"""
    return replace(joint, position=0.0)


@fault("drive_reaches_its_target", needs=_D | Feature.REVOLUTE)
def axis_reversed(joint: Revolute | Prismatic) -> Joint:
    """joints turn and slide the other way"""
    return replace(joint, axis_W=(-joint.axis_W[0], -joint.axis_W[1], -joint.axis_W[2]))


@fault("joint_states_agree_with_the_poses", needs=_TOLD)
class joint_rates_reversed(_Misread):
    """the rates of joints are told with the other sign"""

    def changed(self, states: JointStates) -> JointStates:
        return replace(states, rate=-states.rate)


@fault("joint_states_agree_with_the_poses", needs=_TOLD)
class joint_angles_within_a_turn(_Misread):
    """the angles of joints are told without their full turns"""

    def changed(self, states: JointStates) -> JointStates:
        return replace(states, coordinate=(states.coordinate + np.pi) % (2.0 * np.pi) - np.pi)


@fault("joint_reactions_bear_what_hangs", "joint_reactions_add_up_along_a_chain", needs=_TOLD | Feature.BALL)
class joint_reactions_on_the_parent(_Misread):
    """the reactions of joints are told as they act on the parent"""

    def reaction(self, reaction: Floats) -> Floats:
        return -reaction


@fault("joint_reactions_bear_what_hangs", "joint_reactions_at_the_bottom_of_a_swing", needs=_TOLD)
class joint_reactions_in_the_child(_Misread):
    """the reactions of joints are told in the frame of the child"""

    def reaction(self, reaction: Floats) -> Floats:
        turn = self.now().q_WB[[self.scene.index(joint.child) for joint in self.scene.joints]]
        return np.hstack((rotate_back(turn, reaction[:, :3]), rotate_back(turn, reaction[:, 3:])))


@fault("joint_reactions_bear_what_hangs", needs=_TOLD)
class joint_torques_about_the_centre(_Misread):
    """the torques of joints are told about the centre of mass of the child"""

    def reaction(self, reaction: Floats) -> Floats:
        moved, state = reaction.copy(), self.now()
        for k, joint in enumerate(self.scene.joints):
            child = self.scene.index(joint.child)
            body = self.scene.bodies[child]
            arm = np.asarray(getattr(joint, "anchor_W", body.p_WB)) - np.asarray(body.p_WB)
            lever = rotate(state.q_WB[child], rotate_back(np.asarray(body.q_WB), arm))
            moved[k, 3:] += np.cross(lever, reaction[k, :3])
        return moved


@fault(
    "joint_reactions_bear_what_hangs",
    "joint_reactions_at_the_bottom_of_a_swing",
    "joint_reactions_beside_contacts",
    needs=_TOLD,
)
class joint_reactions_without_weight(_Misread):
    """the reactions of joints are told without the weight of the child"""

    def reaction(self, reaction: Floats) -> Floats:
        weightless = reaction.copy()
        for k, joint in enumerate(self.scene.joints):
            weightless[k, :3] += self.scene.body(joint.child).mass * np.asarray(self.scene.gravity)
        return weightless


@fault("joint_reactions_bear_what_friction_holds", needs=_TOLD | Feature.FRICTION_LOSS)
class friction_reversed_where_the_parent_hangs(_Misread):
    """what dry friction bears is told with the other sign of joints whose parent hangs on their child"""

    def reaction(self, reaction: Floats) -> Floats:
        turned = reaction.copy()
        held = [joint.child for joint in self.scene.joints if joint.parent == WORLD]
        for k, joint in enumerate(self.scene.joints):
            if isinstance(joint, Revolute) and joint.friction_loss and joint.parent != WORLD and joint.child in held:
                axis = np.asarray(joint.axis_W)
                turned[k, 3:] -= 2.0 * axis * (axis @ reaction[k, 3:])
        return turned


@fault("distance_joint_keeps_its_length", needs=Feature.DISTANCE)
def rod_hung_elsewhere(joint: Joint) -> Joint:
    """a rod is hung from another place"""
    return replace(joint, anchor_W=(0.1, 0.1, 0.1)) if isinstance(joint, Distance) else joint


@fault("distance_spring_has_its_frequency", "distance_spring_holds_what_hangs", needs=Feature.DISTANCE_SPRING)
def distance_spring_rests_at_zero(joint: Joint) -> Joint:
    """the rest of a spring between two bodies is lost"""
    return _replaced(joint, "spring", rest=0.0)


@fault("distance_spring_has_its_frequency", "distance_spring_holds_what_hangs", needs=Feature.DISTANCE_SPRING)
def distance_spring_without_damper(joint: Joint) -> Joint:
    """the damper between two bodies is lost"""
    return _replaced(joint, "spring", damping=0.0)


@fault("distance_spring_pulls_where_it_is_tied", needs=Feature.DISTANCE_SPRING)
def distance_spring_tied_to_the_centre(scene: Scene) -> Scene:
    """a spring between two bodies pulls at the child's centre of mass"""
    joints = tuple(replace(j, child_anchor_W=scene.body(j.child).p_WB) if isinstance(j, Distance) else j for j in scene.joints)
    return replace(scene, joints=joints)


@fault("closed_loop_rests_where_it_was_built", needs=Feature.REVOLUTE | Feature.BALL | Feature.CLOSED_LOOP)
class loops_told_elsewhere(Wrapped):
    """bodies that joints hold in a loop are told a millimetre off"""

    def state(self, out: State) -> None:
        self.inner.state(out)
        if len(self.scene.joints) > len(self.scene.bodies):
            out.p_WB[:] += 1e-3
