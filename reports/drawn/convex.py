"""Where parallel rays enter a convex shape: the first hit with its normal, in closed form, for all rays at once.

Rays start at o (n, 3) in the axes of the shape and go along one direction d (3,); a hit is a distance t (n,), infinite where
there is none, with a normal (n, 3).  Source: A. S. Glassner (ed.), An Introduction to Ray Tracing (1989), chapters 2 and 3.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbline.reports.recordings.rotation import Floats

TINY = 1e-12


def entered(shape: Mapping[str, Any], o: Floats, d: Floats) -> tuple[Floats, Floats] | None:
    """The first hit of each ray; None for a shape that is not convex or has no end."""
    match shape["type"]:
        case "sphere":
            return _ellipsoid(np.full(3, float(shape["radius"])), o, d)
        case "ellipsoid":
            return _ellipsoid(np.asarray(shape["semi_axes"], dtype=np.float64), o, d)
        case "box":
            half = np.asarray(shape["half_extents"], dtype=np.float64)
            return _polyhedron(np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([half, half]), o, d)
        case "cylinder":
            return _cylinder(float(shape["radius"]), float(shape["half_length"]), o, d)
        case "capsule":
            return _capsule(float(shape["radius"]), float(shape["half_length"]), o, d)
        case "convex_hull":
            return _polyhedron(*half_spaces(shape), o, d)
    return None


def half_spaces(shape: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Outward normals (m, 3) and distances (m,) m of a hull's faces."""
    from scipy.spatial import ConvexHull  # late: only hulls need it

    faces = np.unique(ConvexHull(np.asarray(shape["vertices"], dtype=np.float64)).equations.round(12), axis=0)
    return faces[:, :3], -faces[:, 3]


def _quadratic(a: Any, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Both roots of a t^2 + 2 b t + c, infinities where there are none: plus before minus, so that nothing lies between."""
    inside = b * b - a * c
    root = np.sqrt(np.maximum(inside, 0.0))
    missed = inside < 0
    return np.where(missed, np.inf, (-b - root) / a), np.where(missed, -np.inf, (-b + root) / a)


def _ellipsoid(axes: Floats, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    u, v = o / axes, d / axes
    t, _ = _quadratic(v @ v, u @ v, np.einsum("ij,ij->i", u, u) - 1.0)
    normal = (u + np.where(np.isfinite(t), t, 0.0)[:, None] * v) / axes
    return t, normal


def _polyhedron(normals: Floats, distances: Floats, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Enters through the last of the faces that are turned towards the rays, before it leaves by the first of the others."""
    rate = normals @ d
    facing, leaving = rate < -TINY, rate > TINY
    if not facing.any() or not leaving.any():
        return np.full(len(o), np.inf), np.zeros_like(o)
    reach = (distances - o @ normals.T) / np.where(np.abs(rate) > TINY, rate, 1.0)
    first = reach[:, facing].argmax(axis=1)
    t = reach[:, facing][np.arange(len(o)), first]
    missed = t > reach[:, leaving].min(axis=1)
    aside = ~facing & ~leaving
    missed |= (o @ normals[aside].T > distances[aside]).any(axis=1)
    return np.where(missed, np.inf, t), normals[facing][first]


def _side(radius: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    """In and out of an endless cylinder about z."""
    a, c = d[0] ** 2 + d[1] ** 2, o[:, 0] ** 2 + o[:, 1] ** 2 - radius**2
    if a < TINY:
        return np.where(c < 0, -np.inf, np.inf), np.where(c < 0, np.inf, -np.inf)
    return _quadratic(a, o[:, 0] * d[0] + o[:, 1] * d[1], c)


def _cylinder(radius: float, half: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    into, out = _side(radius, o, d)
    sign = -1.0 if d[2] > 0 else 1.0
    if abs(d[2]) < TINY:
        inside = np.abs(o[:, 2]) < half
        cap, leave = np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    else:
        cap, leave = (sign * half - o[:, 2]) / d[2], (-sign * half - o[:, 2]) / d[2]
    t = np.maximum(into, cap)
    t = np.where((t < np.minimum(out, leave)) & np.isfinite(t), t, np.inf)
    at = o + np.where(np.isfinite(t), t, 0.0)[:, None] * d
    round_normal = at * [1.0, 1.0, 0.0]
    return t, np.where((into >= cap)[:, None], round_normal, np.array([0.0, 0.0, sign]))


def _capsule(radius: float, half: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    into, _ = _side(radius, o, d)
    z = o[:, 2] + np.where(np.isfinite(into), into, 0.0) * d[2]
    t = np.where(np.isfinite(into) & (np.abs(z) <= half), into, np.inf)
    at = o + np.where(np.isfinite(t), t, 0.0)[:, None] * d
    normal = at * [1.0, 1.0, 0.0]
    for end in (-half, half):
        s, n = _ellipsoid(np.full(3, radius), o - [0.0, 0.0, end], d)
        nearer = s < t
        t, normal = np.where(nearer, s, t), np.where(nearer[:, None], n, normal)
    return t, normal
