"""The negative controls of contacts: forces, gaps, normals, laws of surfaces, and shapes lost on the way."""

from dataclasses import replace

from harness.adapter import Feature
from harness.conformance.faults.broken_contacts import (
    FlippedNormal,
    FrictionScaled,
    HalfForce,
    HalfGap,
    LateForce,
    LingeringForce,
    NormalOfOnePair,
    PositiveGap,
    first_shapes,
    friction_times,
    level_planes,
    restitution_times,
    unplaced_later_shapes,
    unturned_later_shapes,
)
from harness.conformance.faults.broken_scenes import (
    capsule_to_sphere,
    double_extents,
    ellipsoid_to_polyhedron,
    ellipsoid_to_sphere,
    every_body,
    every_surface,
    half_a_capsule,
    rougher,
)
from harness.conformance.faults.control import SLIDES, Control
from harness.conformance.faults.plant import changed_scene, wrapped
from harness.scene import Capsule, Cylinder, PlacedShape, Shape

__all__ = ["CONTACT_CONTROLS"]

_C = Feature.BOX | Feature.CONTACTS
_F = Feature.SPHERE | Feature.CONTACTS | Feature.CONTACT_FORCES
_COMPOUND = Feature.COMPOUND | Feature.SPHERE | Feature.BOX


class _FrictionReversed(FrictionScaled):
    """Hands out friction the other way."""

    factor = -1.0


def _stretched(shape: Shape) -> Shape:
    """The cylindrical part of a round shape taken to be as long as is its half."""
    match shape:
        case Capsule(radius=r, half_length=h):
            return Capsule(radius=r, half_length=h / 2)
        case Cylinder(radius=r, half_length=h):
            return Cylinder(radius=r, half_length=h / 2)
        case _:
            return shape


def _shorter(placed: PlacedShape) -> PlacedShape:
    return replace(placed, shape=_stretched(placed.shape))


CONTACT_CONTROLS: tuple[Control, ...] = (
    Control(
        name="friction_five_percent_strong",
        fault="friction times 1.05",
        plant=every_surface(rougher),
        caught_by=("friction_has_its_size",),
        needs=Feature.BOX,
        applies_to_cases=("stack_tip_or_slide", "friction_painleve", "friction_isotropy", "impact_oblique", *SLIDES),
    ),
    Control(
        name="extents_taken_as_full",
        fault="boxes are twice as large",
        plant=every_body(double_extents),
        caught_by=("box_extents_are_half",),
        needs=Feature.BOX,
        applies_to_cases=("rest_penetration", "stack_tower"),
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
        plant=every_surface(lambda law: replace(law, restitution=law.restitution**2)),
        caught_by=("restitution_of_a_pair",),
        needs=Feature.SPHERE | Feature.RESTITUTION,
        applies_to_cases=("impact_bounce", "impact_oblique", "impact_pairs"),
    ),
    Control(
        name="capsule_replaced_by_a_sphere",
        fault="a capsule is silently a sphere of .1 m",
        plant=every_body(capsule_to_sphere),
        caught_by=("capsule_is_a_capsule",),
        needs=Feature.CAPSULE | Feature.SPHERE,
    ),
    Control(
        name="capsule_sinks_into_boxes",
        fault="a lying capsule touches a box with one of its ends alone",
        plant=changed_scene(half_a_capsule),
        caught_by=("lying_capsule_rests_on_box",),
        needs=Feature.CAPSULE | Feature.SPHERE | Feature.BOX,
    ),
    Control(
        name="ellipsoid_replaced_by_a_ball",
        fault="an ellipsoid is silently the ball of its volume",
        plant=every_body(ellipsoid_to_sphere),
        caught_by=("ellipsoid_is_an_ellipsoid", "ellipsoid_rocks_by_its_curvature"),
        needs=Feature.ELLIPSOID | Feature.SPHERE,
    ),
    Control(
        name="ellipsoid_replaced_by_a_polyhedron",
        fault="an ellipsoid is silently the hull of 162 points on it",
        plant=every_body(ellipsoid_to_polyhedron),
        caught_by=("ellipsoid_rocks_by_its_curvature",),
        needs=Feature.ELLIPSOID | Feature.CONVEX_HULL,
    ),
    Control(
        name="static_friction_dropped",
        fault="only kinetic friction acts",
        plant=every_surface(lambda law: replace(law, static_friction=law.kinetic_friction)),
        caught_by=("static_friction_above_kinetic",),
        needs=Feature.BOX | Feature.STATIC_FRICTION,
        applies_to_cases=("friction_static_kinetic",),
    ),
    Control(
        name="contact_force_one_step_late",
        fault="contact forces are those of the step before",
        plant=wrapped(LateForce),
        caught_by=("contact_forces_move_what_they_touch",),
        needs=_F,
    ),
    Control(
        name="contact_force_outlives_the_contact",
        fault="contact forces stay when bodies have parted",
        plant=wrapped(LingeringForce),
        caught_by=("contact_forces_end_with_the_contact",),
        needs=_F | Feature.RESTITUTION,
    ),
    Control(
        name="contact_friction_dropped",
        fault="contact forces have no friction",
        plant=wrapped(FrictionScaled),
        caught_by=("contact_forces_move_what_they_touch", "sliding_contact_is_on_its_cone"),
        needs=_F,
    ),
    Control(
        name="contact_friction_reversed",
        fault="the friction of contact forces has the other sign",
        plant=wrapped(_FrictionReversed),
        caught_by=("contact_forces_move_what_they_touch", "sliding_contact_is_on_its_cone"),
        needs=_F,
    ),
    Control(
        name="gap_halved",
        fault="gaps are half as large",
        plant=wrapped(HalfGap),
        caught_by=("contacts_of_every_pair_of_shapes",),
        needs=Feature.CONTACTS | Feature.SPHERE | Feature.BOX,
    ),
    Control(
        name="normal_of_one_pair_reversed",
        fault="normals and forces of boxes on spheres point from B to A",
        plant=wrapped(NormalOfOnePair),
        caught_by=("contacts_of_every_pair_of_shapes",),
        needs=Feature.CONTACTS | Feature.SPHERE | Feature.BOX,
    ),
    Control(
        name="third_shape_dropped",
        fault="bodies have two shapes at most",
        plant=every_body(first_shapes(2)),
        caught_by=("compound_stands_on_every_shape",),
        needs=_COMPOUND,
    ),
    Control(
        name="place_of_later_shapes_lost",
        fault="all shapes of a body but the first sit at its centre of mass",
        plant=every_body(unplaced_later_shapes),
        caught_by=("compound_stands_on_every_shape", "compound_keeps_all_shapes"),
        needs=_COMPOUND,
    ),
    Control(
        name="turn_of_later_shapes_lost",
        fault="all shapes of a body but the first stand as the body does",
        plant=every_body(unturned_later_shapes),
        caught_by=("compound_keeps_the_turn_of_every_shape",),
        needs=_COMPOUND,
    ),
    Control(
        name="pose_of_a_plane_lost",
        fault="planes lose their pose in the body",
        plant=every_body(level_planes),
        caught_by=("plane_is_placed_in_its_body",),
        needs=Feature.PLANE | Feature.SPHERE,
    ),
    Control(
        name="lengths_taken_as_whole",
        fault="capsules and cylinders are half as long",
        plant=every_body(lambda body: replace(body, collision=tuple(_shorter(placed) for placed in body.collision))),
        caught_by=("capsule_is_a_capsule", "cylinder_is_a_cylinder"),
        needs=Feature.CAPSULE | Feature.CYLINDER,
    ),
    Control(
        name="friction_one_percent_strong",
        fault="friction times 1.01",
        plant=every_surface(friction_times(1.01)),
        caught_by=("sliding_contact_is_on_its_cone",),
        needs=_F,
    ),
    Control(
        name="friction_three_thousandths_strong",
        fault="friction times 1.003",
        plant=every_surface(friction_times(1.003)),
        caught_by=("sliding_contact_is_on_its_cone",),
        needs=_F,
    ),
    Control(
        name="restitution_three_percent_weak",
        fault="restitution times .97",
        plant=every_surface(restitution_times(0.97)),
        caught_by=("mean_restitution_of_a_pair",),
        needs=Feature.SPHERE | Feature.RESTITUTION,
    ),
    Control(
        name="restitution_one_percent_weak",
        fault="restitution times .99",
        plant=every_surface(restitution_times(0.99)),
        caught_by=("mean_restitution_of_a_pair",),
        needs=Feature.SPHERE | Feature.RESTITUTION,
    ),
    Control(
        name="rolling_friction_dropped",
        fault="rolling friction is left out",
        plant=every_surface(lambda law: replace(law, rolling_friction=0.0)),
        caught_by=("rolling_friction_brakes",),
        needs=Feature.SPHERE | Feature.ROLLING_FRICTION,
    ),
    Control(
        name="torsional_friction_dropped",
        fault="torsional friction is left out",
        plant=every_surface(lambda law: replace(law, torsional_friction=0.0)),
        caught_by=("torsional_friction_brakes",),
        needs=Feature.SPHERE | Feature.TORSIONAL_FRICTION,
    ),
    Control(
        name="friction_everywhere",
        fault="every surface has friction of at least .05",
        plant=every_surface(
            lambda law: replace(
                law, static_friction=max(0.05, law.static_friction), kinetic_friction=max(0.05, law.kinetic_friction)
            )
        ),
        caught_by=("frictionless_is_frictionless",),
        needs=Feature.BOX,
    ),
    Control(
        name="continuous_collision_dropped",
        fault="continuous collision is left out",
        plant=changed_scene(lambda scene: replace(scene, widen=type(scene.widen)(0))),
        caught_by=("continuous_collision_stops_a_fast_ball",),
        needs=Feature.SPHERE | Feature.BOX | Feature.CONTINUOUS_COLLISION,
    ),
)
"""Each on one engine that has what it needs."""
