"""Closed forms and independent integration that checks compare with."""

from math import cos, sin
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import Box, Capsule, Cylinder, Ellipsoid, Plane, Quaternion, Shape, Sphere, Vector3, multiply
from plumbline.harness.trajectory import Floats


def swing(moment: float, inertia: float, t: float) -> tuple[float, float]:
    """Angle [rad] and rate after t [s] of inertia a'' = -moment sin a [kg m2, N m], from rest at 1 rad."""
    motion = solve_ivp(lambda _, y: (y[1], -moment * sin(y[0]) / inertia), (0, t), (1.0, 0.0), rtol=1e-10, atol=1e-10)
    angle, rate = motion.y[:, -1]
    return angle, rate


def pendulum_end(distance: float, angle: float) -> Vector3:
    """Where the end of a pendulum of that length [m] is that turns about y through the origin."""
    return (-distance * sin(angle), 0.0, -distance * cos(angle))


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
