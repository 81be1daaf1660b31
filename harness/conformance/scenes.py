"""Scenes that the checks share, and closed forms and independent integration that they compare with."""

from dataclasses import replace
from math import cos, sin, sqrt
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.adapter import Feature
from plumbline.harness.conformance.check import Compared, NotApplicable, near
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.scene import (
    WORLD,
    Body,
    Box,
    Capsule,
    Cylinder,
    Distance,
    Ellipsoid,
    Matrix3,
    PlacedShape,
    Plane,
    Prismatic,
    Quaternion,
    Revolute,
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


def aligned(what: str, got: Any, expected: Any, within: float, because: str = "") -> Compared:
    """Are the angles [rad] between orientations (4,) or (k, 4) within `within`? NaN is near to nothing."""
    off = kinematics.angle_between(np.asarray(got, dtype=np.float64), np.asarray(expected, dtype=np.float64))
    return near(what, off, np.zeros_like(off), within, because)


def swing(moment: float, inertia: float, t: float) -> tuple[float, float]:
    """Angle [rad] and rate after t [s] of inertia a'' = -moment sin a [kg m2, N m], from rest at 1 rad."""
    motion = solve_ivp(lambda _, y: (y[1], -moment * sin(y[0]) / inertia), (0, t), (1.0, 0.0), rtol=1e-10, atol=1e-10)
    angle, rate = motion.y[:, -1]
    return angle, rate


def pendulum_end(distance: float, angle: float) -> Vector3:
    """Where the end of a pendulum of that length [m] is that turns about y through the origin."""
    return (-distance * sin(angle), 0.0, -distance * cos(angle))


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

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)
TURNED: Quaternion = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
"""A rotation without any symmetry: four different components, none of them zero."""


def vector(row: Any) -> Vector3:
    """The numbers of a row (3,), as a scene takes them."""
    x, y, z = (float(c) for c in row)
    return x, y, z


def symmetric(matrix: Floats) -> Matrix3:
    """A matrix (3, 3) made symmetric to the last bit, as a scene takes an inertia."""
    a, b, c = (vector(row) for row in (matrix + matrix.T) / 2)
    return a, b, c


def free(
    name: str = "body",
    *,
    mass: float = 2.0,
    moments: Vector3 = (0.3, 0.3, 0.3),
    p: Vector3 = ORIGIN,
    q: Quaternion = UPRIGHT,
    v: Vector3 = ORIGIN,
    w: Vector3 = ORIGIN,
) -> Body:
    """A body without a shape: mass [kg] and principal moments [kg m2] alone."""
    return Body(name=name, mass=mass, inertia=principal_inertia(*moments), p_WB=p, q_WB=q, v_WB=v, w_WB=w)


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
    name: str = "block",
    *,
    half: Vector3 = (0.2, 0.2, 0.05),
    mass: float = 1.0,
    p: Vector3 = (0.0, 0.0, 0.05),
    q: Quaternion = UPRIGHT,
    v: Vector3 = ORIGIN,
    w: Vector3 = ORIGIN,
    material: str = "block",
) -> Body:
    """A uniform box of half extents `half` [m]."""
    body, inertia = shaped(name, Box(half_extents=half), material=material, mass=mass), box_inertia(mass, half)
    return replace(body, inertia=inertia, p_WB=p, q_WB=q, v_WB=v, w_WB=w)


def ball(
    name: str = "ball",
    *,
    radius: float = 0.1,
    mass: float = 1.0,
    p: Vector3 = (0.0, 0.0, 0.1),
    v: Vector3 = ORIGIN,
    w: Vector3 = ORIGIN,
) -> Body:
    """A uniform sphere of `radius` [m]."""
    inertia = sphere_inertia(mass, radius)
    return shaped(name, Sphere(radius=radius), mass=mass, inertia=inertia, p_WB=p, v_WB=v, w_WB=w)


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
