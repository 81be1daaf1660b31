"""The negative controls of sensing: rays, pictures, an engine's own sensors, and what is laid over their signals."""

from dataclasses import replace
from math import sqrt

from harness.adapter import Feature
from harness.conformance.faults.broken_pictures import (
    DistantNearPlane,
    EncodedColours,
    HalfAPixelOff,
    MisnamedBodies,
    RangeForDepth,
    ShadowsLeftOut,
)
from harness.conformance.faults.broken_sensors import (
    AnyDirection,
    EndlessRays,
    LateInertial,
    LateRays,
    NormalsOfRaysReversed,
    ThroughKinematic,
    dropouts_follow_ranges,
    late_pictures,
    laws,
    one_seed_for_all_sensors,
    read_downwards,
    reversed_triad,
    share_seed,
    without_levers,
    without_mounts,
)
from harness.conformance.faults.control import Control
from harness.conformance.faults.plant import simulated, wrapped

__all__ = ["SENSING_CONTROLS"]

_R = Feature.BOX | Feature.RENDER
_OWN = ("inertial_sensors_say_what_they_feel",)

SENSING_CONTROLS: tuple[Control, ...] = (
    Control(
        name="noise_from_one_seed",
        fault="all axes of a sensor draw the same noise",
        spoil=share_seed,
        caught_by=("noise_axes_are_independent",),
        applies_to_cases=("sensor_imu_noise", "sensor_lidar_noise"),
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
        name="rays_pass_kinematic_bodies",
        fault="rays pass through kinematic bodies",
        plant=wrapped(ThroughKinematic),
        caught_by=("rays_meet_kinematic_bodies",),
        needs=Feature.RAYS | Feature.KINEMATIC | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="rays_one_step_late",
        fault="rays meet bodies where they were one step ago",
        plant=simulated(lambda inner, engine, scene, settings: LateRays(inner, scene, settings, engine.build(scene, settings))),
        caught_by=("rays_see_the_present_state",),
        needs=Feature.RAYS | Feature.SPHERE,
    ),
    Control(
        name="normals_of_rays_reversed",
        fault="the normals of hits point inwards",
        plant=wrapped(NormalsOfRaysReversed),
        caught_by=("ray_names_body_and_normal",),
        needs=Feature.RAYS,
    ),
    Control(
        name="rays_of_any_length",
        fault="directions are brought to length 1 without a word",
        plant=wrapped(AnyDirection),
        caught_by=("bad_rays_are_refused",),
        needs=Feature.RAYS,
    ),
    Control(
        name="picture_one_step_late",
        fault="pictures show what there was one step ago",
        plant=late_pictures,
        caught_by=("pictures_show_the_present",),
        needs=Feature.RENDER | Feature.BOX | Feature.SPHERE,
    ),
    Control(
        name="lever_of_the_accelerometer_dropped",
        fault="the engine's own accelerometer sits at the centre of mass",
        plant=without_levers,
        caught_by=_OWN,
        needs=Feature.WRENCH,
    ),
    Control(
        name="own_sensors_in_the_body_frame",
        fault="the engine's own sensors speak in the frame of their body",
        plant=without_mounts,
        caught_by=_OWN,
        needs=Feature.WRENCH,
    ),
    Control(
        name="own_sensors_one_step_late",
        fault="the engine's own sensors speak of one step ago",
        plant=wrapped(LateInertial),
        caught_by=_OWN,
        needs=Feature.WRENCH,
    ),
    Control(
        name="one_seed_for_all_sensors",
        fault="all inertial sensors draw the same noise",
        spoil=one_seed_for_all_sensors,
        caught_by=(),
        applies_to_cases=("sensor_streams",),
    ),
    Control(
        name="dropouts_follow_ranges",
        fault="range noise and dropouts come from one stream",
        spoil=dropouts_follow_ranges,
        caught_by=(),
        applies_to_cases=("sensor_lidar_noise",),
    ),
    Control(
        name="misalignment_reversed",
        fault="the triad of an inertial channel is turned the other way",
        sensors=laws(reversed_triad),
        caught_by=(),
        applies_to_cases=("sensor_imu_readout",),
    ),
    Control(
        name="scale_error_dropped",
        fault="the scale error of an inertial channel is left out",
        sensors=laws(lambda law: replace(law, scale_error=0.0)),
        caught_by=(),
        applies_to_cases=("sensor_imu_readout",),
    ),
    Control(
        name="rounded_downwards",
        fault="readings are rounded down instead of to the nearest step",
        sensors=laws(lambda law: replace(law, quantisation=0.0)),
        spoil=read_downwards({"accelerometer": 0.05, "gyroscope": 0.02}),
        caught_by=(),
        applies_to_cases=("sensor_imu_readout",),
    ),
    Control(
        name="saturation_dropped",
        fault="readings go beyond their bound",
        sensors=laws(lambda law: replace(law, saturation=None)),
        caught_by=(),
        applies_to_cases=("sensor_imu_readout",),
    ),
    Control(
        name="random_walk_strong_by_sqrt_2",
        fault="the random walk of inertial noise is sqrt(2) times as strong",
        sensors=laws(lambda law: replace(law, random_walk=sqrt(2) * law.random_walk)),
        caught_by=(),
        applies_to_cases=("sensor_imu_noise",),
    ),
    Control(
        name="white_noise_weak_by_sqrt_2",
        fault="the white noise of an inertial channel is taken for a one-sided density",
        sensors=laws(lambda law: replace(law, density=law.density / sqrt(2))),
        caught_by=(),
        applies_to_cases=("sensor_imu_noise", "sensor_streams"),
    ),
)
"""Each on one engine that has what it needs."""
