"""Bodies and small scenes that the checks are made of."""

from dataclasses import replace

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.conformance.check import NotApplicable
from plumbline.harness.scene import (
    Body,
    Box,
    PlacedShape,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    Surface,
    Vector3,
    axis_angle,
    box_inertia,
    multiply,
    principal_inertia,
    sphere_inertia,
)

G = 9.81
"""Size of the gravity of the scenes here [m/s2]."""

TURNED: Quaternion = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
"""A rotation without any symmetry: four different components, none of them zero."""


def free(
    name: str = "body",
    *,
    mass: float = 2.0,
    moments: Vector3 = (0.3, 0.3, 0.3),
    p: Vector3 = (0.0, 0.0, 0.0),
    q: Quaternion = (1.0, 0.0, 0.0, 0.0),
    v: Vector3 = (0.0, 0.0, 0.0),
    w: Vector3 = (0.0, 0.0, 0.0),
) -> Body:
    """A body without a shape: mass [kg] and principal moments [kg m2] alone."""
    return Body(name=name, mass=mass, inertia=principal_inertia(*moments), p_WB=p, q_WB=q, v_WB=v, w_WB=w)


def damped(body: Body, *, linear: float = 0.0, angular: float = 0.0) -> Body:
    """The same body with damping [1/s] of its velocities."""
    return replace(body, linear_damping=linear, angular_damping=angular)


def without_gravity(*bodies: Body) -> Scene:
    """Bodies that meet nobody, in empty space."""
    return Scene(bodies=bodies, gravity=(0.0, 0.0, 0.0))


def block(
    name: str = "block",
    *,
    half: Vector3 = (0.2, 0.2, 0.05),
    mass: float = 1.0,
    p: Vector3 = (0.0, 0.0, 0.05),
    q: Quaternion = (1.0, 0.0, 0.0, 0.0),
    v: Vector3 = (0.0, 0.0, 0.0),
    w: Vector3 = (0.0, 0.0, 0.0),
    material: str = "block",
) -> Body:
    """A uniform box of half extents `half` [m]."""
    return Body(
        name=name,
        mass=mass,
        inertia=box_inertia(mass, half),
        collision=(PlacedShape(shape=Box(half_extents=half)),),
        material=material,
        p_WB=p,
        q_WB=q,
        v_WB=v,
        w_WB=w,
    )


def ball(
    name: str = "ball",
    *,
    radius: float = 0.1,
    mass: float = 1.0,
    p: Vector3 = (0.0, 0.0, 0.1),
    v: Vector3 = (0.0, 0.0, 0.0),
    w: Vector3 = (0.0, 0.0, 0.0),
    material: str = "block",
) -> Body:
    """A uniform sphere of `radius` [m]."""
    return Body(
        name=name,
        mass=mass,
        inertia=sphere_inertia(mass, radius),
        collision=(PlacedShape(shape=Sphere(radius=radius)),),
        material=material,
        p_WB=p,
        v_WB=v,
        w_WB=w,
    )


def static(
    name: str,
    shape: Shape,
    *,
    p: Vector3 = (0.0, 0.0, 0.0),
    q: Quaternion = (1.0, 0.0, 0.0, 0.0),
    material: str = "ground",
) -> Body:
    """A shape that never moves."""
    return Body(name=name, motion="static", collision=(PlacedShape(shape=shape),), material=material, p_WB=p, q_WB=q)


def floor(adapter: Adapter, *, height: float = 0.0) -> Body:
    """The ground at z = height [m]: a plane where the engine has one, else a box 40 m wide and 1 m thick."""
    if Feature.PLANE in adapter.features:
        return static("ground", Plane(), p=(0.0, 0.0, height))
    if Feature.BOX in adapter.features:
        return static("ground", Box(half_extents=(20.0, 20.0, 0.5)), p=(0.0, 0.0, height - 0.5))
    raise NotApplicable("the engine claims neither a plane nor a box that could be the ground")


def ground(friction: float = 0.0, restitution: float = 0.0, material: str = "block") -> Surface:
    """The law between the ground and `material`."""
    return Surface(between=("ground", material), static_friction=friction, kinetic_friction=friction, restitution=restitution)


def on_ground(
    adapter: Adapter, *bodies: Body, friction: float = 0.5, restitution: float = 0.0, gravity: Vector3 = (0.0, 0.0, -G)
) -> Scene:
    """Bodies of material 'block' above the ground; among themselves they touch by the same law."""
    laws = [ground(friction, restitution)]
    if sum(b.movable for b in bodies) > 1:
        laws.append(
            Surface(between=("block", "block"), static_friction=friction, kinetic_friction=friction, restitution=restitution)
        )
    return Scene(bodies=(floor(adapter), *bodies), surfaces=tuple(laws), gravity=gravity)
