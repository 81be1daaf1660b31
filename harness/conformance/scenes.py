"""Scenes that the checks share, and closed forms and independent integration that they compare with."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Adapter, Feature
from plumbline.harness.conformance.check import NotApplicable
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
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
    rotation_matrix,
    sphere_inertia,
)
from plumbline.harness.trajectory import Floats, kinematics


def rotation(q: Any) -> Floats:
    """The matrix R_WB of a quaternion (w, x, y, z), shape (3, 3)."""
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def angle_between(a: Any, b: Any) -> float:
    """The angle [rad] of the rotation between two quaternions, which may differ in sign and length; NaN stays NaN."""
    return float(kinematics.angle_between(np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)))


def turned_by(q: Quaternion, w: Any, t: float) -> Floats:
    """The orientation after turning with the constant angular velocity w [rad/s, in W] for t [s]."""
    speed = float(np.linalg.norm(w))
    axis = np.asarray(w) / speed
    x, y, z = (float(c) for c in np.sin(speed * t / 2) * axis)
    return np.array(multiply((float(np.cos(speed * t / 2)), x, y, z), q), dtype=np.float64)


def turning(inertia: Any, q: Quaternion, w: Any, t: float, tau_W: Any = (0.0, 0.0, 0.0)) -> tuple[Floats, Floats]:
    """Orientation and angular velocity in W after t [s] under a constant torque tau_W [N m].

    Equation: w_B' = I^-1 (R^T tau_W - w_B x I w_B), q' = q (0, w_B) / 2.
    Source: Goldstein, Classical Mechanics, 3rd ed., eq. 5.39; integrated by DOP853 at 1e-12.
    """
    tensor, torque = np.asarray(inertia, dtype=np.float64), np.asarray(tau_W, dtype=np.float64)

    def rate(_: float, y: Floats) -> Floats:
        w_B = y[4:]
        q_dot = 0.5 * np.array(multiply((y[0], y[1], y[2], y[3]), (0.0, w_B[0], w_B[1], w_B[2])))
        w_dot = np.linalg.solve(tensor, rotation(y[:4]).T @ torque - np.cross(w_B, tensor @ w_B))
        return np.concatenate((q_dot, w_dot))

    start = np.concatenate((q, rotation(q).T @ np.asarray(w, dtype=np.float64)))
    end = solve_ivp(rate, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    q_end = end[:4] / np.linalg.norm(end[:4])
    return q_end, rotation(q_end) @ end[4:]


def _ball(o: Floats, d: Floats, radius: float, centre: float) -> float:
    c = o - np.array([0.0, 0.0, centre])
    b = float(c @ d)
    root = b * b - float(c @ c) + radius * radius
    return -b - float(np.sqrt(root)) if root >= 0 and -b - np.sqrt(root) >= 0 else np.inf


def _tube(o: Floats, d: Floats, radius: float, half_length: float) -> float:
    a = float(d[:2] @ d[:2])
    if a == 0:
        return np.inf
    b, c = float(o[:2] @ d[:2]), float(o[:2] @ o[:2]) - radius * radius
    root = b * b - a * c
    if root < 0:
        return np.inf
    t = (-b - float(np.sqrt(root))) / a
    return t if t >= 0 and abs(o[2] + t * d[2]) <= half_length else np.inf


def _caps(o: Floats, d: Floats, radius: float, half_length: float) -> float:
    best = np.inf
    for z in (-half_length, half_length):
        if d[2] != 0:
            t = (z - o[2]) / d[2]
            if t >= 0 and float(np.hypot(*(o[:2] + t * d[:2]))) <= radius:
                best = min(best, float(t))
    return best


def first_hit(shape: Shape, o: Floats, d: Floats) -> float:
    """Distance [m] along the unit direction d from o, outside the shape, both in its frame S; inf for a miss."""
    match shape:
        case Sphere(radius=r):
            return _ball(o, d, r, 0.0)
        case Capsule(radius=r, half_length=h):
            return min(_ball(o, d, r, -h), _ball(o, d, r, h), _tube(o, d, r, h))
        case Cylinder(radius=r, half_length=h):
            return min(_tube(o, d, r, h), _caps(o, d, r, h))
        case Ellipsoid(semi_axes=semi_axes):
            p, u = o / semi_axes, d / semi_axes
            stretch = float(np.linalg.norm(u))
            return _ball(p, u / stretch, 1.0, 0.0) / stretch
        case Plane(normal=n):
            across = float(np.dot(d, n))
            return -float(np.dot(o, n)) / across if across < 0 else np.inf
        case Box(half_extents=half):
            with np.errstate(divide="ignore"):
                a, b = (-np.array(half) - o) / d, (np.array(half) - o) / d
            enter, leave = float(np.minimum(a, b).max()), float(np.maximum(a, b).min())
            return enter if 0 <= enter <= leave else np.inf
        case _:
            raise NotImplementedError(f"no closed form for {shape.type}")


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
