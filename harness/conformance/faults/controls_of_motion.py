"""The negative controls of motion: gravity, frames, single steps, digits, forces, damping, sleep and clamps."""

from dataclasses import replace

from harness.adapter import Feature
from harness.conformance.faults.broken_belts import Deaf, Late, Teleported, TurnsInPlace
from harness.conformance.faults.broken_motion import Sleepy, clamped, losing_speed
from harness.conformance.faults.broken_scenes import every_body, gravity, swap_inertia
from harness.conformance.faults.broken_states import BodyAngularVelocity, OneStepBehind, ScalarLast, Shuffled
from harness.conformance.faults.broken_steps import (
    DeafToLengths,
    KinematicStandsStill,
    NeverIdle,
    NoGyroscopicTorque,
    PushesAtShapes,
    ReversedWrench,
    SinglePrecision,
    SlowIsStill,
    TorqueDropped,
    braked,
    twice_the_step,
    uneven,
)
from harness.conformance.faults.control import SLIDES, Control
from harness.conformance.faults.plant import simulated, wrapped
from harness.scene import Body, principal_inertia

__all__ = ["MOTION_CONTROLS"]

_TOPS = ("spin_asymmetric_top", "spin_intermediate_axis", "spin_symmetric_top")
_SWINGS = (
    "joint_chain", "joint_conical_pendulum", "joint_double_pendulum", "joint_fourbar", "joint_limits", "joint_pendulum"
)  # fmt: skip
"""Cases by what moves in them, as far as they notice the same faults."""

_W = Feature.WRENCH
_POINT = Feature.MASS_POINT | Feature.FIXED | Feature.REVOLUTE
_FALL = "free_fall_has_the_size_and_sign_of_g"
_FINE = "gravity_has_three_digits"


def _bloated(body: Body) -> Body:
    """A mass point becomes a solid ball of 1 m."""
    moment = 0.4 * body.mass
    return replace(body, inertia=principal_inertia(moment, moment, moment)) if body.mass_point else body


class _MicrometresAreStill(SlowIsStill):
    """Reads a micrometre a second as none."""

    threshold = 1.001e-6


MOTION_CONTROLS: tuple[Control, ...] = (
    Control(
        name="gravity_upside_down",
        fault="gravity with the wrong sign",
        plant=gravity(-1.0),
        caught_by=(_FALL, "gravity_is_a_vector"),
        applies_to_cases=(
            "stand_quadruped",
            "stack_overhang",
            "stack_card_house",
            "stack_pyramid",
            "flight_*",
            "friction_*",
            "rest_*",
            "stack_tower",
            "impact_bounce",
            "spin_heavy_top",
            "tunnel_thin_mesh",
            *_SWINGS,
        ),
    ),
    Control(
        name="gravity_two_percent_strong",
        fault="gravity times 1.02",
        plant=gravity(1.02),
        caught_by=(_FALL, "gravity_is_a_vector"),
        applies_to_cases=("flight_*", "friction_threshold", "impact_bounce", *_SWINGS),
    ),
    Control(
        name="twice_the_time_step",
        fault="each step advances 2 dt",
        plant=twice_the_step,
        caught_by=("step_advances_exactly_dt", _FALL),
        applies_to_cases=(
            "orbit_kepler",
            "joint_double_pendulum_chaotic",
            "flight_*",
            "spin_heavy_top",
            "spin_principal",
            "joint_spring",
            "impact_bounce",
            "impact_oblique",
            "impact_pairs",
            "sensor_imu_noise",
            *_TOPS,
            *_SWINGS,
            *SLIDES,
            "friction_rolling_resistance",
            "friction_turntable",
        ),
    ),
    Control(
        name="no_gyroscopic_torque",
        fault="the term w x I w is dropped",
        plant=wrapped(NoGyroscopicTorque),
        caught_by=("gyroscopic_term_is_present",),
        needs=_W,
        applies_to_cases=("spin_heavy_top", *_TOPS),
    ),
    Control(
        name="angular_velocity_in_the_body_frame",
        fault="w is handed out in B",
        plant=wrapped(BodyAngularVelocity),
        caught_by=("angular_velocity_is_in_W", "initial_state_comes_back"),
        applies_to_cases=("stand_hit", "spin_fast", "impact_gas", "impact_momentum", "impact_oblique", *_TOPS),
    ),
    Control(
        name="quaternion_scalar_last",
        fault="quaternions are handed out as (x, y, z, w)",
        plant=wrapped(ScalarLast),
        caught_by=("quaternion_is_wxyz", "initial_state_comes_back"),
        applies_to_cases=("spin_principal", *_TOPS),
    ),
    Control(
        name="inertia_axes_exchanged",
        fault="the first two rows and columns of the inertia are exchanged",
        plant=every_body(swap_inertia),
        caught_by=("inertia_is_in_B",),
        applies_to_cases=("stand_hit", "spin_asymmetric_top", "spin_intermediate_axis"),
    ),
    Control(
        name="hidden_damping",
        fault="velocities lose 4 % a second",
        plant=losing_speed,
        caught_by=("hidden_damping_is_off",),
        applies_to_cases=(
            "orbit_kepler",
            "joint_double_pendulum_chaotic",
            "flight_*",
            "spin_principal",
            "joint_spring",
            "friction_backspin",
            "friction_roll_incline",
            "friction_slip_to_roll",
            "impact_cradle",
            "impact_gas",
            "impact_momentum",
            "impact_oblique",
            "impact_pairs",
            "sensor_imu_noise",
            *_TOPS,
            "joint_chain",
            "joint_conical_pendulum",
            "joint_double_pendulum",
            "joint_fourbar",
            "joint_pendulum",
            "friction_rolling_resistance",
        ),
    ),
    Control(
        name="sleeping",
        fault="bodies slower than .1 m/s for .1 s are put to sleep",
        plant=simulated(Sleepy),
        caught_by=("sleeping_is_off",),
        applies_to_cases=("friction_threshold", "friction_wall_pinch"),
    ),
    Control(
        name="state_one_step_behind",
        fault="the state is that of one step ago",
        plant=wrapped(OneStepBehind),
        caught_by=("step_advances_exactly_dt",),
        applies_to_cases=("flight_*", "spin_principal", "sensor_imu_noise"),
    ),
    Control(
        name="velocity_clamped",
        fault="100 m/s and 100 rad/s are the most",
        plant=simulated(clamped),
        caught_by=("velocity_is_not_clamped",),
    ),
    Control(
        name="body_order_permuted",
        fault="the first body comes last",
        plant=wrapped(Shuffled),
        caught_by=("body_order_is_kept", "initial_state_comes_back"),
    ),
    Control(
        name="mass_ten_percent_light",
        fault="masses times .9",
        plant=every_body(lambda body: replace(body, mass=0.9 * body.mass)),
        caught_by=("wrench_has_sign_and_size",),
        needs=_W,
    ),
    Control(
        name="wrench_reversed",
        fault="forces push the other way",
        plant=wrapped(ReversedWrench),
        caught_by=("wrench_has_sign_and_size",),
        needs=_W,
    ),
    Control(
        name="initial_velocity_dropped",
        fault="every body starts from rest",
        plant=every_body(lambda body: replace(body, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0))),
        caught_by=("initial_state_comes_back",),
        applies_to_cases=("flight_*", "spin_heavy_top", "spin_principal", *_TOPS),
    ),
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
        name="step_lengths_ignored",
        fault="every step is dt long, whatever is told for it",
        plant=wrapped(DeafToLengths),
        caught_by=("step_lengths_are_kept",),
        needs=Feature.STEP_LENGTHS,
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
        name="products_of_inertia_dropped",
        fault="the inertia keeps its diagonal alone",
        plant=every_body(
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
        name="prescribed_motion_ignored",
        fault="bodies whose motion is prescribed stay where they are",
        plant=wrapped(Deaf),
        caught_by=(
            "prescribed_motion_is_where_its_law_has_it",
            "prescribed_plate_takes_along_what_friction_can",
            "prescribed_platform_lifts_what_it_meets",
            "prescribed_paddle_sweeps_a_ball_outwards",
        ),
        needs=Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="prescribed_motion_a_step_late",
        fault="bodies whose motion is prescribed are a step late",
        plant=wrapped(Late),
        caught_by=("prescribed_motion_is_where_its_law_has_it",),
        needs=Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="prescribed_turn_in_place",
        fault="bodies that are turned about an axis turn about their own middle",
        plant=wrapped(TurnsInPlace),
        caught_by=(
            "prescribed_motion_is_where_its_law_has_it",
            "prescribed_paddle_sweeps_a_ball_outwards",
        ),
        needs=Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="prescribed_motion_without_velocity",
        fault="bodies whose motion is prescribed are put in their places and have no velocity",
        plant=simulated(Teleported),
        caught_by=("prescribed_plate_takes_along_what_friction_can",),
        needs=Feature.PRESCRIBED_MOTION | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="mass_point_given_an_extent",
        fault="a mass point is silently a ball of 1 m",
        plant=every_body(_bloated),
        caught_by=("mass_point_counts_where_it_is_fixed",),
        needs=_POINT,
    ),
    Control(
        name="mass_point_ten_percent_light",
        fault="mass points weigh .9 of what they should",
        plant=every_body(lambda body: replace(body, mass=0.9 * body.mass) if body.mass_point else body),
        caught_by=("mass_point_flies_and_hangs",),
        needs=_POINT | Feature.DISTANCE_SPRING,
    ),
)
"""Each on one engine that has what it needs."""
