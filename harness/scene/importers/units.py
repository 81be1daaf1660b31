"""A robot whose file counts in centimetres or grams, in SI units."""

from collections.abc import Container
from dataclasses import replace

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Shape, Sphere, TriangleMesh
from plumbline.harness.scene.importers.companion import Units
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.poses import Pose
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Geometry, Link, Look, Robot, Solid

SUSPECT = 50.0
"""Gravity [m/s2] above which a file's unit of length is probably not the metre: twice that of Jupiter."""


def suspected(robot: Robot, units: Units | None) -> list[Fidelity]:
    """A row where gravity is that of no planet in metres, and no unit is told."""
    strength = 0.0 if robot.gravity is None else float(np.linalg.norm(robot.gravity))
    if units is not None or strength <= SUSPECT:
        return []
    return [
        Fidelity(
            element="gravity",
            name="",
            outcome="exact",
            becomes="read in m/s2",
            consequence="the file probably counts in another unit of length: [units] length = 0.01, mass = 0.001 for centi"
            "metres and grams; its gravity is",
            value=strength,
            unit="m/s2",
        )
    ]


def scaled(robot: Robot, units: Units) -> Robot:
    """All lengths, masses and what is made of them, seconds and radians left as they are. Raises: RobotError."""
    if robot.tendons:
        raise RobotError(
            f"{robot.source}: tendon {quoted(robot.tendons[0].name, 80)}: its length has a unit of its own, expected no "
            "[units] in the companion file; --drop tendon leaves tendons out"
        )
    length = units.length
    slides = frozenset(c.name for link in robot.links for c in link.coordinates if c.kind == "prismatic")
    return replace(
        robot,
        links=tuple(_link(link, units, slides) for link in robot.links),
        closures=tuple(_closure(closure, length, units.mass) for closure in robot.closures),
        gravity=None
        if robot.gravity is None
        else (robot.gravity[0] * length, robot.gravity[1] * length, robot.gravity[2] * length),
        contacts=None
        if robot.contacts is None
        else replace(
            robot.contacts,
            laws=tuple(
                replace(
                    law,
                    rolling_friction=law.rolling_friction * length,
                    torsional_friction=law.torsional_friction * length,
                )
                for law in robot.contacts.laws
            ),
        ),
    )


def _pose(X: Pose, length: float) -> Pose:
    return Pose(X.R, X.p * length)


def _closure(closure: Closure, length: float, mass: float) -> Closure:
    return replace(
        closure,
        anchor_A=closure.anchor_A * length,
        anchor_B=closure.anchor_B * length,
        stiffness=closure.stiffness * mass,
        damping=closure.damping * mass,
        rest=closure.rest * length,
    )


def _link(link: Link, units: Units, slides: Container[str]) -> Link:
    L, M = units.length, units.mass
    solid = link.solid
    if solid is not None:
        inertia = None if solid.inertia is None else solid.inertia * (M * L * L)
        solid = Solid(solid.mass * M, solid.centre * L, inertia)
    return replace(
        link,
        X_PL=_pose(link.X_PL, L),
        solid=solid,
        coordinates=tuple(_coordinate(c, L, M, slides) for c in link.coordinates),
        geometries=tuple(Geometry(_shape(g.shape, L), _pose(g.X_LG, L), g.contact) for g in link.geometries),
        drawn=tuple(Geometry(_shape(g.shape, L), _pose(g.X_LG, L), g.contact) for g in link.drawn),
        looks=tuple(_look(look, L) for look in link.looks),
    )


def _look(look: Look, L: float) -> Look:
    x, y, z = look.scale
    return replace(
        look,
        X_LG=_pose(look.X_LG, L),
        shape=None if look.shape is None else _shape(look.shape, L),
        scale=(x * L, y * L, z * L),
        vertices=None if look.vertices is None else look.vertices * L,
    )


def _coordinate(c: Coordinate, L: float, M: float, slides: Container[str]) -> Coordinate:
    """A coordinate's own unit is a length or none; a stiffness is force over it, and so on. Args: slides: by name."""
    own = L if c.kind == "prismatic" else 1.0
    force = M * L * L / own

    def length(value: float | None) -> float | None:
        return None if value is None else value * own

    tie = c.tie
    if tie is not None:
        other = L if tie.joint in slides else 1.0
        tie = replace(tie, ratio=tie.ratio * own / other, offset=tie.offset * own)
    servo = c.servo
    if servo is not None:
        servo = replace(
            servo,
            stiffness=servo.stiffness * force / own,
            damping=servo.damping * force / own,
            target=servo.target * own,
            target_velocity=servo.target_velocity * own,
            limit=None if servo.limit is None else servo.limit * force,
            feedforward=servo.feedforward * force,
            push=servo.push * force,
        )
    return replace(
        c,
        anchor=c.anchor * L,
        reference=c.reference * own,
        lower=length(c.lower),
        upper=length(c.upper),
        rest=c.rest * own,
        position=length(c.position),
        velocity=c.velocity * own,
        speed=length(c.speed),
        stiffness=c.stiffness * force / own,
        damping=c.damping * force / own,
        armature=c.armature * force / own,
        friction_loss=c.friction_loss * force,
        tie=tie,
        effort=None if c.effort is None else c.effort * force,
        servo=servo,
        X_start=None if c.X_start is None else _pose(c.X_start, L),
        v_start=None if c.v_start is None else c.v_start * L,
    )


def _shape(shape: Shape, L: float) -> Shape:
    match shape:
        case Sphere(radius=r):
            return Sphere(radius=r * L)
        case Box(half_extents=(x, y, z)):
            return Box(half_extents=(x * L, y * L, z * L))
        case Ellipsoid(semi_axes=(x, y, z)):
            return Ellipsoid(semi_axes=(x * L, y * L, z * L))
        case Cylinder(radius=r, half_length=h):
            return Cylinder(radius=r * L, half_length=h * L)
        case Capsule(radius=r, half_length=h):
            return Capsule(radius=r * L, half_length=h * L)
        case ConvexHull(vertices=vertices):
            return ConvexHull(vertices=(np.array(vertices) * L).tolist())
        case TriangleMesh(vertices=vertices, faces=faces):
            return TriangleMesh(vertices=(np.array(vertices) * L).tolist(), faces=faces)
        case _:
            return shape
