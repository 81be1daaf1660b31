"""The planted faults of scenes: what an engine is told of bodies, surfaces, joints and gravity is changed."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from harness.adapter import Adapter
from harness.conformance.exact import rotation
from harness.conformance.faults.plant import changed_scene
from harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Distance,
    Ellipsoid,
    PlacedShape,
    Prismatic,
    Revolute,
    Scene,
    Sphere,
    Surface,
    polyhedron_of,
)

__all__ = [
    "every_body",
    "capsule_to_sphere",
    "double_extents",
    "ellipsoid_to_polyhedron",
    "ellipsoid_to_sphere",
    "gravity",
    "half_a_capsule",
    "every_joint",
    "rougher",
    "stiffer",
    "every_surface",
    "swap_inertia",
    "tied_to_centres",
]


def every_body(change: Callable[[Body], Body]) -> Callable[[Adapter], Adapter]:
    """Every body is changed."""
    return changed_scene(lambda scene: replace(scene, bodies=tuple(change(body) for body in scene.bodies)))


def gravity(factor: float) -> Callable[[Adapter], Adapter]:
    """Gravity times a factor."""

    def change(scene: Scene) -> Scene:
        x, y, z = scene.gravity
        return replace(scene, gravity=(factor * x, factor * y, factor * z))

    return changed_scene(change)


def every_surface(change: Callable[[Surface], Surface]) -> Callable[[Adapter], Adapter]:
    """Every surface is changed."""
    return changed_scene(lambda scene: replace(scene, surfaces=tuple(change(surface) for surface in scene.surfaces)))


def every_joint(change: Callable[[Revolute | Prismatic], Any]) -> Callable[[Adapter], Adapter]:
    """Every joint with a coordinate is changed."""

    def apply(scene: Scene) -> Scene:
        return replace(scene, joints=tuple(change(j) if isinstance(j, Revolute | Prismatic) else j for j in scene.joints))

    return changed_scene(apply)


def rougher(law: Surface) -> Surface:
    """Friction times 1.05."""
    return replace(law, static_friction=1.05 * law.static_friction, kinetic_friction=1.05 * law.kinetic_friction)


def swap_inertia(body: Body) -> Body:
    """The first two rows and columns of the inertia change places."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia
    return replace(body, inertia=((yy, xy, yz), (xy, xx, xz), (yz, xz, zz)))


def double_extents(body: Body) -> Body:
    """Every box is twice as large."""

    def doubled(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Box(half_extents=(a, b, c)):
                return replace(placed, shape=Box(half_extents=(2 * a, 2 * b, 2 * c)))
            case _:
                return placed

    return replace(body, collision=tuple(doubled(placed) for placed in body.collision))


def capsule_to_sphere(body: Body) -> Body:
    """Every capsule becomes a sphere of .1 m."""
    kept = tuple(replace(p, shape=Sphere(radius=0.1)) if p.shape.type == "capsule" else p for p in body.collision)
    return replace(body, collision=kept)


def ellipsoid_to_sphere(body: Body) -> Body:
    """Every ellipsoid becomes the ball of its volume."""

    def rounded(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Ellipsoid(semi_axes=(a, b, c)):
                return replace(placed, shape=Sphere(radius=(a * b * c) ** (1 / 3)))
            case _:
                return placed

    return replace(body, collision=tuple(rounded(placed) for placed in body.collision))


def ellipsoid_to_polyhedron(body: Body) -> Body:
    """Every ellipsoid becomes the hull of 162 points on it."""

    def cut(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Ellipsoid():
                return replace(placed, shape=ConvexHull(vertices=polyhedron_of(placed.shape)))
            case _:
                return placed

    return replace(body, collision=tuple(cut(placed) for placed in body.collision))


def half_a_capsule(scene: Scene) -> Scene:
    """Beside boxes every capsule touches with one of its ends alone."""
    if not any(placed.shape.type == "box" for body in scene.bodies for placed in body.collision):
        return scene

    def halved(placed: PlacedShape) -> PlacedShape:
        match placed.shape:
            case Capsule(radius=r, half_length=h):
                end = rotation(np.array(placed.q_BS)) @ (0.0, 0.0, h) + np.array(placed.p_BS)
                return replace(placed, shape=Sphere(radius=r), p_BS=(float(end[0]), float(end[1]), float(end[2])))
            case _:
                return placed

    return replace(
        scene,
        bodies=tuple(
            replace(body, collision=tuple(halved(placed_shape) for placed_shape in body.collision)) for body in scene.bodies
        ),
    )


def stiffer(joint: Revolute | Prismatic) -> Revolute | Prismatic:
    """Springs are 10 % stiffer."""
    return (
        joint if joint.spring is None else replace(joint, spring=replace(joint.spring, stiffness=1.1 * joint.spring.stiffness))
    )


def tied_to_centres(scene: Scene) -> Scene:
    """Distances begin at the centre of mass of their child."""
    joints = tuple(replace(j, child_anchor_W=scene.body(j.child).p_WB) if isinstance(j, Distance) else j for j in scene.joints)
    return replace(scene, joints=joints)
