"""The negative controls of motion: single steps, digits, forces, joints, drives and saves."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from harness.adapter import Feature
from harness.conformance.faults.broken_engines import bodies, gravity, told, wrapped
from harness.conformance.faults.broken_steps import (
    CommandsFirstDriveOnly,
    DeafToUnknownJoints,
    KinematicStandsStill,
    NeverIdle,
    PushesAtShapes,
    ReshapesWrench,
    RestoreKeepsTargets,
    RestoreKeepsWrench,
    SinglePrecision,
    SlowIsStill,
    TorqueDropped,
    braked,
    joined,
    uneven,
)
from harness.conformance.faults.control import Control
from harness.scene import Distance, Joint, Prismatic, Revolute

__all__ = ["MOTION_CONTROLS"]

_W, _D = Feature.WRENCH, Feature.PRISMATIC | Feature.DRIVES
_FINE = "gravity_has_three_digits"


class _MicrometresAreStill(SlowIsStill):
    """Reads a micrometre a second as none."""

    threshold = 1.001e-6


def _without(part: str, **changed: float | None) -> Callable[[Any], Joint]:
    """A change of joints: the named fields of their drive or spring are replaced."""

    def change(joint: Any) -> Joint:
        law = getattr(joint, part, None)
        changed_joint: Joint = joint if law is None else replace(joint, **{part: replace(law, **changed)})
        return changed_joint

    return change


MOTION_CONTROLS: tuple[Control, ...] = (
    Control(
        name="gravity_half_a_percent_weak",
        fault="gravity times .995",
        plant=gravity(0.995),
        caught_by=(_FINE,),
    ),
    Control(
        name="gravity_a_thousandth_weak",
        fault="gravity times .999",
        plant=gravity(0.999),
        caught_by=(_FINE,),
    ),
    Control(
        name="uneven_steps",
        fault="steps of .9 and 1.1 dt in turns",
        plant=uneven,
        caught_by=("steps_are_even",),
    ),
    Control(
        name="no_step_is_a_step",
        fault="step(0) takes a step",
        plant=wrapped(NeverIdle),
        caught_by=("no_step_is_no_step",),
    ),
    Control(
        name="damping_of_1e-4_a_second",
        fault="velocities lose 1e-4 of themselves a second",
        plant=braked(1e-4),
        caught_by=("nothing_brakes_a_free_body",),
        needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING,
    ),
    Control(
        name="damping_of_1e-5_a_second",
        fault="velocities lose 1e-5 of themselves a second",
        plant=braked(1e-5),
        caught_by=("nothing_brakes_a_free_body",),
        needs=Feature.LINEAR_DAMPING | Feature.ANGULAR_DAMPING,
    ),
    Control(
        name="slow_is_still",
        fault="speeds below 1e-3 m/s and rad/s are read as 0",
        plant=wrapped(SlowIsStill),
        caught_by=("slow_motion_is_motion",),
    ),
    Control(
        name="micrometres_are_still",
        fault="speeds of 1e-6 m/s and rad/s are read as 0",
        plant=wrapped(_MicrometresAreStill),
        caught_by=("slow_motion_is_motion",),
    ),
    Control(
        name="states_in_single_precision",
        fault="states are handed out in float32 where float64 is claimed",
        plant=wrapped(SinglePrecision),
        caught_by=("states_have_double_precision",),
    ),
    Control(
        name="push_at_the_shapes",
        fault="forces act where the first shape is, not at the centre of mass",
        plant=wrapped(PushesAtShapes),
        caught_by=("push_acts_at_the_centre_of_mass",),
        needs=_W | Feature.SPHERE,
    ),
    Control(
        name="torque_dropped",
        fault="torques handed in are forgotten",
        plant=wrapped(TorqueDropped),
        caught_by=("wrench_has_sign_and_size",),
        needs=_W,
    ),
    Control(
        name="wrench_of_any_shape",
        fault="a wrench of a wrong shape, type or content is made to fit",
        plant=wrapped(ReshapesWrench),
        caught_by=("bad_wrenches_are_refused",),
        needs=_W,
    ),
    Control(
        name="products_of_inertia_dropped",
        fault="the inertia keeps its diagonal alone",
        plant=bodies(
            lambda b: replace(
                b, inertia=((b.inertia[0][0], 0.0, 0.0), (0.0, b.inertia[1][1], 0.0), (0.0, 0.0, b.inertia[2][2]))
            )
        ),
        caught_by=("products_of_inertia_count",),
        needs=Feature.FULL_INERTIA,
    ),
    Control(
        name="kinematic_stands_still",
        fault="kinematic bodies stand where they started",
        plant=wrapped(KinematicStandsStill),
        caught_by=("kinematic_body_keeps_its_velocity",),
        needs=Feature.KINEMATIC | Feature.BOX,
    ),
    Control(
        name="target_velocity_dropped",
        fault="the target velocity of a drive is lost",
        plant=joined(_without("drive", target_velocity=0.0)),
        caught_by=("target_velocity_acts",),
        needs=_D,
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
        name="rod_hung_elsewhere",
        fault="a rod is hung from another place",
        plant=told(
            lambda scene: replace(
                scene,
                joints=tuple(replace(j, anchor_W=(0.1, 0.1, 0.1)) if isinstance(j, Distance) else j for j in scene.joints),
            )
        ),
        caught_by=("distance_joint_keeps_its_length",),
        needs=Feature.DISTANCE,
    ),
    Control(
        name="restore_keeps_the_wrench",
        fault="the wrench outlives a restore",
        plant=wrapped(RestoreKeepsWrench),
        caught_by=("restore_brings_back_the_wrench",),
        needs=Feature.SAVE | _W,
    ),
    Control(
        name="restore_keeps_the_targets",
        fault="the targets of drives outlive a restore",
        plant=wrapped(RestoreKeepsTargets),
        caught_by=("restore_brings_back_the_targets",),
        needs=Feature.SAVE | _D,
    ),
)
"""Each on one engine that has what it needs."""
