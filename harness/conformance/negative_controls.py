"""Planted faults: engines broken in exactly one way each, which the checks must catch and name."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from harness.adapter import Adapter, Feature
from harness.conformance.broken_engines import (
    BodyAngularVelocity,
    ClosesOnce,
    EndlessRays,
    FlippedNormal,
    ForgetfulSave,
    HalfForce,
    NanWithoutAWord,
    NoGyroscopicTorque,
    NoSpinWritten,
    OddWarnings,
    OneStepBehind,
    PositiveGap,
    ReversedWrench,
    ScalarLast,
    Shuffled,
    Taciturn,
    approximating,
    bodies,
    capsule_to_sphere,
    clamped,
    deaf_to_methods,
    deaf_to_options,
    double_extents,
    entangled,
    gravity,
    half_a_capsule,
    joints,
    losing_speed,
    repairing,
    rougher,
    share_seed,
    simulated,
    sleepy,
    stiffer,
    surfaces,
    swap_inertia,
    told,
    twice_the_step,
    unrepeatable,
    wrapped,
)
from harness.conformance.broken_pictures import (
    DistantNearPlane,
    EncodedColours,
    HalfAPixelOff,
    MisnamedBodies,
    RangeForDepth,
    ShadowsLeftOut,
)
from harness.conformance.faults import plant
from harness.scene import (
    Effect,
)
from harness.trajectory import Trajectory

__all__ = ["CONTROLS", "Control"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """One planted fault.

    Terms:
        name, fault: what is broken, in snake case and in words. caught_by: the conformance checks of which at least one must
        fail, each of which passes on the sound engine. needs: features without which the fault cannot show.
        plant: the adapter with the fault. spoil: the same for a recorded trajectory, for faults behind the engine.
        applies_to_cases: patterns of case names that should notice it as well.
    """

    name: str
    fault: str
    caught_by: tuple[str, ...]
    plant: Callable[[Adapter], Adapter] = lambda adapter: adapter
    spoil: Callable[[Trajectory], Trajectory] = lambda trajectory: trajectory
    needs: Feature = Feature.NONE
    applies_to_cases: tuple[str, ...] = ()

    @property
    def on_trajectory(self) -> bool:
        """Does the fault lie behind the engine, in recorded streams?"""
        return not self.caught_by or self.caught_by == ("noise_axes_are_independent",)


_TOPS = ("spin_asymmetric_top", "spin_intermediate_axis", "spin_symmetric_top")
_SWINGS = (
    "joint_chain", "joint_conical_pendulum", "joint_double_pendulum", "joint_fourbar", "joint_limits", "joint_pendulum"
)  # fmt: skip
_SLIDES = (
    "friction_backspin", "friction_roll_incline", "friction_slip_to_roll", "friction_spinning", "friction_static_kinetic",
    "friction_stop", "friction_threshold", "friction_wall_pinch",
)  # fmt: skip
"""Cases by what moves in them, as far as they notice the same faults."""

_C, _W, _R = Feature.BOX | Feature.CONTACTS, Feature.WRENCH, Feature.BOX | Feature.RENDER
_FALL = "free_fall_has_the_size_and_sign_of_g"

CONTROLS: tuple[Control, ...] = (
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
        name="friction_five_percent_strong",
        fault="friction times 1.05",
        plant=surfaces(rougher),
        caught_by=("friction_has_its_size",),
        needs=Feature.BOX,
        applies_to_cases=("stack_tip_or_slide", "friction_painleve", "friction_isotropy", "impact_oblique", *_SLIDES),
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
            *_SLIDES,
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
        plant=bodies(swap_inertia),
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
        plant=simulated(sleepy),
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
        name="noise_from_one_seed",
        fault="all axes of a sensor draw the same noise",
        spoil=share_seed,
        caught_by=("noise_axes_are_independent",),
        applies_to_cases=("sensor_imu_noise", "sensor_lidar_noise"),
    ),
    Control(
        name="extents_taken_as_full",
        fault="boxes are twice as large",
        plant=bodies(double_extents),
        caught_by=("box_extents_are_half",),
        needs=Feature.BOX,
        applies_to_cases=("rest_penetration", "stack_tower"),
    ),
    Control(
        name="velocity_clamped",
        fault="100 m/s and 100 rad/s are the most",
        plant=simulated(clamped),
        caught_by=("velocity_is_not_clamped",),
    ),
    Control(
        name="nan_repaired_in_silence",
        fault="a state that is not finite is replaced by the start at rest",
        plant=simulated(repairing),
        caught_by=("nan_is_reported",),
    ),
    Control(
        name="body_order_permuted",
        fault="the first body comes last",
        plant=wrapped(Shuffled),
        caught_by=("body_order_is_kept", "initial_state_comes_back"),
    ),
    Control(
        name="contact_normal_flipped",
        fault="normals point from B to A",
        plant=wrapped(FlippedNormal),
        caught_by=("contact_normal_points_from_A_to_B",),
        needs=_C,
    ),
    Control(
        name="gap_positive_in_penetration",
        fault="penetration is handed out as a positive gap",
        plant=wrapped(PositiveGap),
        caught_by=("gap_is_negative_in_penetration",),
        needs=_C | Feature.SPHERE,
    ),
    Control(
        name="contact_force_halved",
        fault="contact forces are half as large",
        plant=wrapped(HalfForce),
        caught_by=("contact_forces_carry_the_weight",),
        needs=_C | Feature.CONTACT_FORCES,
    ),
    Control(
        name="restitution_squared",
        fault="a combination rule multiplies the restitution with itself",
        plant=surfaces(lambda law: replace(law, restitution=law.restitution**2)),
        caught_by=("restitution_of_a_pair",),
        needs=Feature.SPHERE | Feature.RESTITUTION,
        applies_to_cases=("impact_bounce", "impact_oblique", "impact_pairs"),
    ),
    Control(
        name="capsule_replaced_by_a_sphere",
        fault="a capsule is silently a sphere of .1 m",
        plant=bodies(capsule_to_sphere),
        caught_by=("capsule_is_a_capsule",),
        needs=Feature.CAPSULE | Feature.SPHERE,
    ),
    Control(
        name="capsule_sinks_into_boxes",
        fault="a lying capsule touches a box with one of its ends alone",
        plant=told(half_a_capsule),
        caught_by=("lying_capsule_rests_on_box",),
        needs=Feature.CAPSULE | Feature.SPHERE | Feature.BOX,
    ),
    Control(
        name="mass_ten_percent_light",
        fault="masses times .9",
        plant=bodies(lambda body: replace(body, mass=0.9 * body.mass)),
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
        name="rays_without_end",
        fault="rays reach ten times as far as asked",
        plant=wrapped(EndlessRays),
        caught_by=("ray_beyond_max_range_misses",),
        needs=Feature.RAYS,
    ),
    Control(
        name="range_for_depth",
        fault="depth images hold distances from the pinhole",
        plant=wrapped(RangeForDepth),
        caught_by=("image_is_z_depth", "image_is_cut_near_the_camera"),
        needs=_R,
    ),
    Control(
        name="half_a_pixel_off",
        fault="the centre of the first pixel is taken to be at (0, 0)",
        plant=wrapped(HalfAPixelOff),
        caught_by=("pixel_centre_is_at_half",),
        needs=_R,
    ),
    Control(
        name="misnamed_bodies",
        fault="images count bodies from 1",
        plant=wrapped(MisnamedBodies),
        caught_by=("image_names_bodies",),
        needs=_R,
    ),
    Control(
        name="distant_near_plane",
        fault="images leave out what is nearer than half a metre",
        plant=wrapped(DistantNearPlane),
        caught_by=("image_is_cut_near_the_camera",),
        needs=_R,
    ),
    Control(
        name="encoded_colours",
        fault="colours are encoded for screens",
        plant=wrapped(EncodedColours),
        caught_by=("image_is_lit_by_sun_and_sky",),
        needs=_R,
    ),
    Control(
        name="shadows_left_out",
        fault="a rasterised image is passed off as a ray-traced one",
        plant=wrapped(ShadowsLeftOut),
        caught_by=("ray_traced_image_has_shadows",),
        needs=Feature.RAY_TRACING | Feature.BOX,
    ),
    Control(
        name="save_keeps_nothing",
        fault="restore goes nowhere",
        plant=wrapped(ForgetfulSave),
        caught_by=("save_and_restore_is_exact",),
        needs=Feature.SAVE,
    ),
    Control(
        name="limits_dropped",
        fault="joint limits are ignored",
        plant=joints(lambda joint: replace(joint, limits=None)),
        caught_by=("limits_hold",),
        needs=Feature.REVOLUTE | Feature.LIMITS,
    ),
    Control(
        name="spring_ten_percent_stiff",
        fault="joint springs are 10 % too stiff",
        plant=joints(stiffer),
        caught_by=("spring_frequency",),
        needs=Feature.PRISMATIC | Feature.SPRINGS,
        applies_to_cases=("joint_spring",),
    ),
    Control(
        name="initial_velocity_dropped",
        fault="every body starts from rest",
        plant=bodies(lambda body: replace(body, v_WB=(0.0, 0.0, 0.0), w_WB=(0.0, 0.0, 0.0))),
        caught_by=("initial_state_comes_back",),
        applies_to_cases=("flight_*", "spin_heavy_top", "spin_principal", *_TOPS),
    ),
    Control(
        name="unknown_options_dropped",
        fault="an option that the adapter does not know is ignored",
        plant=deaf_to_options,
        caught_by=("unknown_option_is_refused",),
    ),
    Control(
        name="unknown_methods_dropped",
        fault="an integrator or solver that the engine does not have is replaced by its own",
        plant=deaf_to_methods,
        caught_by=("unknown_integrator_is_refused", "unknown_solver_is_refused"),
    ),
    Control(
        name="claims_too_much",
        fault="every feature is claimed",
        plant=lambda adapter: replace(plant(adapter), features=~Feature.NONE),
        caught_by=("claimed_features_build",),
    ),
    Control(
        name="closes_once",
        fault="closing a second time fails",
        plant=wrapped(ClosesOnce),
        caught_by=("close_may_be_called_twice",),
    ),
    Control(
        name="resolved_says_nothing",
        fault="the settings in use are not told",
        plant=wrapped(Taciturn),
        caught_by=("resolved_settings_are_complete",),
    ),
    Control(
        name="angular_velocity_not_written",
        fault="the caller's w is left as it was",
        plant=wrapped(NoSpinWritten),
        caught_by=("state_is_written_into_the_given_arrays", "initial_state_comes_back"),
    ),
    Control(
        name="nan_without_a_word",
        fault="positions become NaN after fifty steps and nobody says so",
        plant=wrapped(NanWithoutAWord),
        caught_by=("heavy_on_light_is_finite_or_diverged",),
        needs=Feature.BOX,
        applies_to_cases=("flight_*", "rest_*"),
    ),
    Control(
        name="surplus_by_no_name",
        fault="a surplus is declared that is no effect",
        plant=wrapped(OddWarnings),
        caught_by=("surplus_names_effects",),
    ),
    Control(
        name="not_repeatable",
        fault="each build differs by a rounding",
        plant=unrepeatable,
        caught_by=("same_input_same_hash",),
    ),
    Control(
        name="simulations_entangled",
        fault="stepping one simulation steps the others",
        plant=entangled,
        caught_by=("two_simulations_share_no_state",),
    ),
    Control(
        name="joined_bodies_collide",
        fault="bodies held by a joint collide all the same",
        plant=told(lambda scene: replace(scene, joints=tuple(replace(joint, collide=True) for joint in scene.joints))),
        caught_by=("joined_bodies_do_not_collide",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="joined_bodies_never_collide",
        fault="bodies held by a joint pass through each other although the joint lets them collide",
        plant=told(lambda scene: replace(scene, joints=tuple(replace(joint, collide=False) for joint in scene.joints))),
        caught_by=("joined_bodies_collide_when_told",),
        needs=Feature.REVOLUTE | Feature.BOX,
    ),
    Control(
        name="narrowing_ignored",
        fault="effects that the scene leaves out are simulated all the same, and not declared",
        plant=told(lambda scene: replace(scene, narrow=Effect.NONE)),
        caught_by=("narrowed_gravity_is_left_out", "narrowed_contact_is_left_out"),
        needs=Feature.SPHERE,
    ),
    Control(
        name="static_friction_dropped",
        fault="only kinetic friction acts",
        plant=surfaces(lambda law: replace(law, static_friction=law.kinetic_friction)),
        caught_by=("static_friction_above_kinetic",),
        needs=Feature.BOX | Feature.STATIC_FRICTION,
        applies_to_cases=("friction_static_kinetic",),
    ),
    Control(
        name="approximates_in_silence",
        fault="what is not supported is left out without a word",
        plant=approximating,
        caught_by=("unclaimed_features_raise_unsupported",),
    ),
)
"""Every planted fault."""
