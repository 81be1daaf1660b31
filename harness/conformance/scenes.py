"""Scenes that the checks share: bodies, joints and the ground, with little said."""

from dataclasses import replace
from math import sqrt
from typing import Any, TypedDict, Unpack

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import NotApplicable
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.conformance.frames import ORIGIN, UPRIGHT
from plumbline.harness.scene.body import Body, PlacedShape
from plumbline.harness.scene.joint import WORLD, Distance, Prismatic, Revolute
from plumbline.harness.scene.scene import Scene, Surface
from plumbline.harness.scene.shape import Box, Plane, Shape, Sphere, box_inertia, principal_inertia, sphere_inertia
from plumbline.harness.scene.values import Quaternion, Vector3

G = 9.81
"""Size of the gravity of the scenes here [m/s2]."""


class At(TypedDict, total=False):
    """Where a body is and how it moves at the start: p_WB [m], q_WB, v_WB [m/s], w_WB [rad/s]."""

    p: Vector3
    q: Quaternion
    v: Vector3
    w: Vector3


def _put(body: Body, at: At) -> Body:
    put: Any = {f"{name}_WB": value for name, value in at.items()}
    return replace(body, **put)


def free(name: str = "body", *, mass: float = 2.0, moments: Vector3 = (0.3, 0.3, 0.3), **at: Unpack[At]) -> Body:
    """A body without a shape: mass [kg] and principal moments [kg m2] alone."""
    return _put(Body(name=name, mass=mass, inertia=principal_inertia(*moments)), at)


def damped(body: Body, *, linear: float = 0.0, angular: float = 0.0) -> Body:
    """The same body with damping [1/s] of its velocities."""
    return replace(body, linear_damping=linear, angular_damping=angular)


def without_gravity(*bodies: Body, **fields: Any) -> Scene:
    """Bodies in empty space; `fields` are those of a scene."""
    return Scene(bodies=bodies, gravity=ORIGIN, **fields)


def shaped(name: str, *shapes: Shape | PlacedShape, material: str = "block", **fields: Any) -> Body:
    """A body of these shapes, each at the centre of mass unless it is placed; `fields` are those of a body."""
    placed = tuple(shape if isinstance(shape, PlacedShape) else PlacedShape(shape=shape) for shape in shapes)
    return Body(name=name, collision=placed, material=material, **fields)


def block(
    name: str = "block", *, half: Vector3 = (0.2, 0.2, 0.05), mass: float = 1.0, material: str = "block", **at: Unpack[At]
) -> Body:
    """A uniform box of half extents `half` [m]."""
    body = shaped(name, Box(half_extents=half), material=material, mass=mass, inertia=box_inertia(mass, half))
    return _put(body, {"p": (0.0, 0.0, 0.05), **at})


def ball(name: str = "ball", *, radius: float = 0.1, mass: float = 1.0, **at: Unpack[At]) -> Body:
    """A uniform sphere of `radius` [m]."""
    body = shaped(name, Sphere(radius=radius), mass=mass, inertia=sphere_inertia(mass, radius))
    return _put(body, {"p": (0.0, 0.0, 0.1), **at})


def static(name: str, shape: Shape, *, p: Vector3 = ORIGIN, q: Quaternion = UPRIGHT, material: str = "ground") -> Body:
    """A shape that never moves."""
    return shaped(name, shape, motion="static", material=material, p_WB=p, q_WB=q)


def static_cube(name: str, half: float, p: Vector3 = ORIGIN) -> Body:
    """A static cube with edges of twice `half` [m]."""
    return static(name, Box(half_extents=(half, half, half)), p=p)


def revolute(name: str, child: str, anchor: Vector3, axis: Vector3, *, parent: str = WORLD, **laws: Any) -> Revolute:
    """A hinge on the world or another body; `laws` are fields of a joint."""
    return Revolute(name=name, parent=parent, child=child, anchor_W=anchor, axis_W=axis, **laws)


def prismatic(name: str, child: str, anchor: Vector3, axis: Vector3, *, parent: str = WORLD, **laws: Any) -> Prismatic:
    """A slide on the world or another body; `laws` are fields of a joint."""
    return Prismatic(name=name, parent=parent, child=child, anchor_W=anchor, axis_W=axis, **laws)


def tie(name: str, child: str, anchor: Vector3, child_anchor: Vector3, *, parent: str = WORLD, **laws: Any) -> Distance:
    """A rod, or a spring, between points of the world or another body and of the child."""
    return Distance(name=name, parent=parent, child=child, anchor_W=anchor, child_anchor_W=child_anchor, **laws)


def floor(engine: Engine) -> Body:
    """The ground at z = 0: a plane where the engine has one, else a box 40 m wide and 1 m thick."""
    if Feature.PLANE in engine.features:
        return static("ground", Plane())
    if Feature.BOX in engine.features:
        return static("ground", Box(half_extents=(20.0, 20.0, 0.5)), p=(0.0, 0.0, -0.5))
    raise NotApplicable("the engine claims neither a plane nor a box that could be the ground")


def lean(slope: float) -> Vector3:
    """Gravity as it acts on a slope [1] that falls along x, in the frame of the slope [m/s2]."""
    return (G * slope / sqrt(1 + slope**2), 0.0, -G / sqrt(1 + slope**2))


def ground(friction: float = 0.0, restitution: float = 0.0, material: str = "block", other: str = "ground") -> Surface:
    """The law between the ground, or another material, and `material`."""
    return Surface.rough(friction, (other, material), restitution=restitution)


def on_ground(
    engine: Engine, *bodies: Body, friction: float = 0.5, restitution: float = 0.0, gravity: Vector3 = (0.0, 0.0, -G)
) -> Scene:
    """Bodies of material 'block' above the ground; among themselves they touch by the same law."""
    among = [ground(friction, restitution, other="block")] if sum(b.movable for b in bodies) > 1 else []
    return Scene(bodies=(floor(engine), *bodies), surfaces=(ground(friction, restitution), *among), gravity=gravity)
