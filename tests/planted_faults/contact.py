"""The planted faults of contacts: forces, gaps, normals, laws of surfaces, and shapes lost on the way."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Surface,
    polyhedron_of,
)
from plumbline.harness.trajectory import Contacts, Floats
from tests.planted_faults.fault import SLIDES, fault
from tests.planted_faults.planting import Wrapped, every_shape

_C = Feature.BOX | Feature.CONTACTS
_F = Feature.SPHERE | Feature.CONTACTS | Feature.CONTACT_FORCES
_COMPOUND = Feature.COMPOUND | Feature.SPHERE | Feature.BOX


def _along(got: Contacts) -> Floats:
    """The normal parts (k, 3) N of the forces."""
    along: Floats = np.sum(got.force_W * got.normal_W, axis=1)[:, None] * got.normal_W
    return along


def _later(body: Body, change: Callable[[PlacedShape], PlacedShape]) -> Body:
    """All shapes of a body but the first are changed."""
    return replace(body, collision=body.collision[:1] + tuple(change(placed) for placed in body.collision[1:]))


def _friction_times(law: Surface, factor: float) -> Surface:
    return replace(law, static_friction=factor * law.static_friction, kinetic_friction=factor * law.kinetic_friction)


@fault(
    "friction_has_its_size",
    needs=Feature.BOX,
    cases=("stack_tip_or_slide", "friction_painleve", "friction_isotropy", "impact_oblique", *SLIDES),
)
def friction_five_percent_strong(law: Surface) -> Surface:
    """friction times 1.05"""
    return _friction_times(law, 1.05)


@fault("box_extents_are_half", needs=Feature.BOX, cases=("rest_penetration", "stack_tower"))
def extents_taken_as_full(placed: PlacedShape) -> PlacedShape:
    """boxes are twice as large"""
    match placed.shape:
        case Box(half_extents=(a, b, c)):
            return replace(placed, shape=Box(half_extents=(2 * a, 2 * b, 2 * c)))
        case _:
            return placed


@fault("contact_normal_points_from_A_to_B", needs=_C)
class contact_normal_flipped(Wrapped):
    """normals point from B to A"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        return replace(got, normal_W=-got.normal_W)


@fault("contact_point_is_half_way", needs=_C | Feature.SPHERE | Feature.BOX)
class contact_point_on_one_surface(Wrapped):
    """the points of contacts lie on the surface of the first body"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        return replace(got, point_W=got.point_W - got.gap[:, None] / 2 * got.normal_W)


@fault("gap_is_negative_in_penetration", needs=_C | Feature.SPHERE)
class gap_positive_in_penetration(Wrapped):
    """penetration is handed out as a positive gap"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        return replace(got, gap=-got.gap)


@fault("contact_forces_carry_the_weight", needs=_C | Feature.CONTACT_FORCES)
class contact_force_halved(Wrapped):
    """contact forces are half as large"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        return replace(got, force_W=got.force_W / 2)


@fault(
    "restitution_of_a_pair",
    needs=Feature.SPHERE | Feature.RESTITUTION,
    cases=("impact_bounce", "impact_oblique", "impact_pairs"),
)
def restitution_squared(law: Surface) -> Surface:
    """a combination rule multiplies the restitution with itself"""
    return replace(law, restitution=law.restitution**2)


@fault("capsule_is_a_capsule", needs=Feature.CAPSULE | Feature.SPHERE)
def capsule_replaced_by_a_sphere(placed: PlacedShape) -> PlacedShape:
    """a capsule is silently a sphere of .1 m"""
    return replace(placed, shape=Sphere(radius=0.1)) if isinstance(placed.shape, Capsule) else placed


@fault("lying_capsule_rests_on_box", needs=Feature.CAPSULE | Feature.SPHERE | Feature.BOX)
def capsule_sinks_into_boxes(scene: Scene) -> Scene:
    """a lying capsule touches a box with one of its ends alone"""
    if not any(placed.shape.type == "box" for body in scene.bodies for placed in body.collision):
        return scene

    def halved(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Capsule(radius=r, half_length=h):
                end = rotation(np.array(placed.q_BS)) @ (0.0, 0.0, h) + np.array(placed.p_BS)
                return replace(placed, shape=Sphere(radius=r), p_BS=(float(end[0]), float(end[1]), float(end[2])))
            case _:
                return placed

    return every_shape(halved)(scene)


@fault("ellipsoid_is_an_ellipsoid", "ellipsoid_rocks_by_its_curvature", needs=Feature.ELLIPSOID | Feature.SPHERE)
def ellipsoid_replaced_by_a_ball(placed: PlacedShape) -> PlacedShape:
    """an ellipsoid is silently the ball of its volume"""
    match placed.shape:
        case Ellipsoid(semi_axes=(a, b, c)):
            return replace(placed, shape=Sphere(radius=(a * b * c) ** (1 / 3)))
        case _:
            return placed


@fault("ellipsoid_rocks_by_its_curvature", needs=Feature.ELLIPSOID | Feature.CONVEX_HULL)
def ellipsoid_replaced_by_a_polyhedron(placed: PlacedShape) -> PlacedShape:
    """an ellipsoid is silently the hull of 162 points on it"""
    if not isinstance(placed.shape, Ellipsoid):
        return placed
    return replace(placed, shape=ConvexHull(vertices=polyhedron_of(placed.shape)))


@fault("static_friction_above_kinetic", needs=Feature.BOX | Feature.STATIC_FRICTION, cases=("friction_static_kinetic",))
def static_friction_dropped(law: Surface) -> Surface:
    """only kinetic friction acts"""
    return replace(law, static_friction=law.kinetic_friction)


@fault("contact_forces_move_what_they_touch", needs=_F)
class contact_force_one_step_late(Wrapped):
    """contact forces are those of the step before"""

    def start(self) -> None:
        self._before = Contacts.none()

    def step(self, count: int = 1) -> None:
        if count > 1:
            self.inner.step(count - 1)
        if count > 0:
            self._before = self.inner.contacts()
            self.inner.step()

    def contacts(self) -> Contacts:
        return self._before


@fault("contact_forces_end_with_the_contact", needs=_F | Feature.RESTITUTION)
class contact_force_outlives_the_contact(Wrapped):
    """contact forces stay when bodies have parted"""

    def start(self) -> None:
        self._last = Contacts.none()

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        if got.force_W.any():
            self._last = got
        return self._last


@fault("contact_forces_move_what_they_touch", "sliding_contact_is_on_its_cone", needs=_F)
class contact_friction_dropped(Wrapped):
    """contact forces have no friction"""

    factor = 0.0

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        normal = _along(got)
        return replace(got, force_W=normal + self.factor * (got.force_W - normal))


@fault("contact_forces_move_what_they_touch", "sliding_contact_is_on_its_cone", needs=_F)
class contact_friction_reversed(contact_friction_dropped):
    """the friction of contact forces has the other sign"""

    factor = -1.0


@fault("contacts_of_every_pair_of_shapes", needs=Feature.CONTACTS | Feature.SPHERE | Feature.BOX)
class gap_halved(Wrapped):
    """gaps are half as large"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        return replace(got, gap=got.gap / 2)


@fault("contacts_of_every_pair_of_shapes", needs=Feature.CONTACTS | Feature.SPHERE | Feature.BOX)
class normal_of_one_pair_reversed(Wrapped):
    """normals and forces of boxes on spheres point from B to A"""

    def contacts(self) -> Contacts:
        got = self.inner.contacts()
        kinds = [{placed.shape.type for placed in body.collision} for body in self.scene.bodies]
        odd = np.array(
            [kinds[a] | kinds[b] == {"box", "sphere"} for a, b in zip(got.body_A, got.body_B, strict=True)], dtype=bool
        )
        sign = np.where(odd, -1.0, 1.0)[:, None]
        return replace(got, normal_W=sign * got.normal_W, force_W=sign * got.force_W)


@fault("compound_stands_on_every_shape", needs=_COMPOUND)
def third_shape_dropped(body: Body) -> Body:
    """bodies have two shapes at most"""
    return replace(body, collision=body.collision[:2])


@fault("compound_stands_on_every_shape", "compound_keeps_all_shapes", needs=_COMPOUND)
def place_of_later_shapes_lost(body: Body) -> Body:
    """all shapes of a body but the first sit at its centre of mass"""
    return _later(body, lambda placed: replace(placed, p_BS=(0.0, 0.0, 0.0)))


@fault("compound_keeps_the_turn_of_every_shape", needs=_COMPOUND)
def turn_of_later_shapes_lost(body: Body) -> Body:
    """all shapes of a body but the first stand as the body does"""
    return _later(body, lambda placed: replace(placed, q_BS=(1.0, 0.0, 0.0, 0.0)))


@fault("plane_is_placed_in_its_body", needs=Feature.PLANE | Feature.SPHERE)
def pose_of_a_plane_lost(placed: PlacedShape) -> PlacedShape:
    """planes lose their pose in the body"""
    return PlacedShape(shape=placed.shape) if isinstance(placed.shape, Plane) else placed


@fault("capsule_is_a_capsule", "cylinder_is_a_cylinder", needs=Feature.CAPSULE | Feature.CYLINDER)
def lengths_taken_as_whole(placed: PlacedShape) -> PlacedShape:
    """capsules and cylinders are half as long"""
    if not isinstance(placed.shape, Capsule | Cylinder):
        return placed
    return replace(placed, shape=replace(placed.shape, half_length=placed.shape.half_length / 2))


@fault("sliding_contact_is_on_its_cone", needs=_F)
def friction_one_percent_strong(law: Surface) -> Surface:
    """friction times 1.01"""
    return _friction_times(law, 1.01)


@fault("sliding_contact_is_on_its_cone", needs=_F)
def friction_three_thousandths_strong(law: Surface) -> Surface:
    """friction times 1.003"""
    return _friction_times(law, 1.003)


@fault("mean_restitution_of_a_pair", needs=Feature.SPHERE | Feature.RESTITUTION)
def restitution_three_percent_weak(law: Surface) -> Surface:
    """restitution times .97"""
    return replace(law, restitution=0.97 * law.restitution)


@fault("mean_restitution_of_a_pair", needs=Feature.SPHERE | Feature.RESTITUTION)
def restitution_one_percent_weak(law: Surface) -> Surface:
    """restitution times .99"""
    return replace(law, restitution=0.99 * law.restitution)


@fault("rolling_friction_brakes", needs=Feature.SPHERE | Feature.ROLLING_FRICTION)
def rolling_friction_dropped(law: Surface) -> Surface:
    """rolling friction is left out"""
    return replace(law, rolling_friction=0.0)


@fault("torsional_friction_brakes", needs=Feature.SPHERE | Feature.TORSIONAL_FRICTION)
def torsional_friction_dropped(law: Surface) -> Surface:
    """torsional friction is left out"""
    return replace(law, torsional_friction=0.0)


@fault("frictionless_is_frictionless", needs=Feature.BOX)
def friction_everywhere(law: Surface) -> Surface:
    """every surface has friction of at least .05"""
    return replace(law, static_friction=max(0.05, law.static_friction), kinetic_friction=max(0.05, law.kinetic_friction))


@fault("box_on_parallel_edges_is_borne", needs=Feature.BOX)
def boxes_on_parallel_edges_missed(scene: Scene) -> Scene:
    """a box meets none, if it shares the direction of one edge alone with another box"""
    boxes = [body for body in scene.bodies if len(body.collision) == 1 and isinstance(body.collision[0].shape, Box)]
    parallel = {
        (a.name, b.name): int(np.count_nonzero(np.abs(rotation(a.q_WB).T @ rotation(b.q_WB)) > 1 - 1e-9))
        for a, b in combinations(boxes, 2)
    }
    missed = {name for pair, edges in parallel.items() if edges == 1 for name in pair}
    lost = (replace(body, collision=()) if body.movable and body.name in missed else body for body in scene.bodies)
    return replace(scene, bodies=tuple(lost))


@fault("continuous_collision_stops_a_fast_ball", needs=Feature.SPHERE | Feature.BOX | Feature.CONTINUOUS_COLLISION)
def continuous_collision_dropped(scene: Scene) -> Scene:
    """continuous collision is left out"""
    return replace(scene, widen=type(scene.widen)(0))
