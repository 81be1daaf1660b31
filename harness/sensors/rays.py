"""First hits of rays on the primitives in closed form: what an engine's rays are measured against.

Rays start outside all solids. A sphere is solved from the foot of the perpendicular on the ray, so that a grazing ray does not
lose digits to the difference of large squares. An ellipsoid is a unit sphere in
coordinates that are divided by its semi-axes. A capsule is the union of a cylinder's side and two balls. A hull is the
intersection of the half-spaces of its faces; a mesh is met wherever a triangle of it is, from outside or behind.

Source: Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems (2019), chapter 7; Kay and Kajiya,
"Ray tracing complex scenes" (1986) for slabs; Ericson, Real-Time Collision Detection, section 5.3; Moeller, Trumbore, Fast
minimum storage ray/triangle intersection (1997).
"""

from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Scene, Shape, Sphere, TriangleMesh
from plumbline.harness.trajectory import Floats, Hits, State
from plumbline.harness.trajectory.kinematics import product, rotate, rotate_back

Met = tuple[Floats, Floats]
"""Distance (r,) m, infinite where nothing is met, and outward unit normal (r, 3), zero there."""

_NO_NORMAL = np.zeros(3)


def _met(distance: Floats, hit: NDArray[np.bool_], normal: Floats) -> Met:
    hit = hit & (distance > 0)
    return np.where(hit, distance, np.inf), np.where(hit[:, None], normal, _NO_NORMAL)


def _nearer(a: Met, b: Met) -> Met:
    first = a[0] <= b[0]
    return np.where(first, a[0], b[0]), np.where(first[:, None], a[1], b[1])


def _sphere(o: Floats, d: Floats, centre: Floats, radius: float) -> Met:
    towards = np.sum((centre - o) * d, axis=1)
    foot = o + towards[:, None] * d - centre
    rest = radius**2 - np.sum(foot * foot, axis=1)
    half = np.sqrt(np.maximum(rest, 0.0))
    return _met(towards - half, rest >= 0, (foot - half[:, None] * d) / radius)


def _ellipsoid(o: Floats, d: Floats, semi_axes: Floats) -> Met:
    """The unit sphere, along a direction that dividing has made `stretch` times as long."""
    divided = d / semi_axes
    stretch = np.linalg.norm(divided, axis=1)
    distance, spot = _sphere(o / semi_axes, divided / stretch[:, None], np.zeros(3), 1.0)
    normal = spot / semi_axes
    with np.errstate(invalid="ignore"):
        normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    return _met(distance / stretch, np.isfinite(distance), np.nan_to_num(normal))


def _plane(o: Floats, d: Floats, normal: Floats) -> Met:
    falling = d @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = -(o @ normal) / falling
    return _met(distance, falling < 0, np.broadcast_to(normal, o.shape))


def _box(o: Floats, d: Floats, half_extents: Floats) -> Met:
    with np.errstate(divide="ignore", invalid="ignore"):
        towards = (-np.copysign(half_extents, d) - o) / d
        away = (np.copysign(half_extents, d) - o) / d
    # A ray along a face's plane is bounded by the other slabs alone if it runs between the two faces.
    between = (d == 0) & (np.abs(o) <= half_extents)
    towards = np.where(d == 0, np.where(between, -np.inf, np.inf), towards)
    away = np.where(d == 0, np.inf, away)
    axis = np.argmax(towards, axis=1)
    entry = np.take_along_axis(towards, axis[:, None], axis=1)[:, 0]
    normal = np.zeros_like(o)
    rows = np.arange(len(o))
    normal[rows, axis] = -np.sign(d[rows, axis])
    return _met(entry, entry <= away.min(axis=1), normal)


def _side(o: Floats, d: Floats, radius: float, half_length: float) -> Met:
    """The curved side of a cylinder along z, as it is met from outside."""
    across = np.hypot(d[:, 0], d[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        u = d[:, :2] / across[:, None]
        towards = -np.sum(o[:, :2] * u, axis=1)
        foot = o[:, :2] + towards[:, None] * u
        rest = radius**2 - np.sum(foot * foot, axis=1)
        half = np.sqrt(np.maximum(rest, 0.0))
        distance = (towards - half) / across
        z = o[:, 2] + distance * d[:, 2]
        normal = np.column_stack([(foot - half[:, None] * u) / radius, np.zeros(len(o))])
        return _met(distance, (across > 0) & (rest >= 0) & (np.abs(z) <= half_length), np.nan_to_num(normal))


def _cap(o: Floats, d: Floats, radius: float, half_length: float) -> Met:
    """The flat ends of a cylinder along z, the one that the ray meets from outside."""
    falling = np.where(d[:, 2] < 0, 1.0, -1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (falling * half_length - o[:, 2]) / d[:, 2]
        at = o + distance[:, None] * d
        hit = (d[:, 2] != 0) & (np.hypot(at[:, 0], at[:, 1]) <= radius)
    normal = np.zeros_like(o)
    normal[:, 2] = falling
    return _met(distance, hit, normal)


def _hull(o: Floats, d: Floats, vertices: Floats) -> Met:
    """The last face that is entered, if no face is left before: half-spaces n.x <= c."""
    from scipy.spatial import ConvexHull as Faces  # late: a listing must not pay for it

    planes = Faces(vertices).equations
    normals, bounds = planes[:, :3], -planes[:, 3]
    rising, height = d @ normals.T, o @ normals.T - bounds
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = -height / rising
    entered = np.where(rising < 0, crossed, np.where((rising == 0) & (height > 0), np.inf, -np.inf))
    left = np.where(rising > 0, crossed, np.inf)
    last = np.argmax(entered, axis=1)
    entry = np.take_along_axis(entered, last[:, None], axis=1)[:, 0]
    return _met(entry, entry <= left.min(axis=1), normals[last])


def _mesh(o: Floats, d: Floats, vertices: Floats, faces: NDArray[np.int64]) -> Met:
    """The nearest of all triangles."""
    best: Met = (np.full(len(o), np.inf), np.zeros_like(o))
    for a, b, c in vertices[faces]:
        normal = np.cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = ((a - o) @ normal) / (d @ normal)
            # Barycentric coordinates, as areas against the whole triangle's.
            within = (o + distance[:, None] * d) - a
            v = np.cross(within, c - a) @ normal / (normal @ normal)
            w = np.cross(b - a, within) @ normal / (normal @ normal)
            hit = np.isfinite(distance) & (v >= 0) & (w >= 0) & (v + w <= 1)
        best = _nearer(best, _met(distance, hit, np.broadcast_to(normal / np.linalg.norm(normal), o.shape)))
    return best


def _shape(shape: Shape, o: Floats, d: Floats) -> Met:
    """In the frame of the shape."""
    match shape:
        case Sphere():
            return _sphere(o, d, np.zeros(3), shape.radius)
        case Plane():
            return _plane(o, d, np.array(shape.normal))
        case Ellipsoid():
            return _ellipsoid(o, d, np.array(shape.semi_axes))
        case Box():
            return _box(o, d, np.array(shape.half_extents))
        case Cylinder():
            return _nearer(_side(o, d, shape.radius, shape.half_length), _cap(o, d, shape.radius, shape.half_length))
        case Capsule():
            end = np.array([0.0, 0.0, shape.half_length])
            balls = _nearer(_sphere(o, d, end, shape.radius), _sphere(o, d, -end, shape.radius))
            return _nearer(_side(o, d, shape.radius, shape.half_length), balls)
        case ConvexHull():
            return _hull(o, d, np.array(shape.vertices))
        case TriangleMesh():
            return _mesh(o, d, np.array(shape.vertices), np.array(shape.faces, dtype=np.int64))
        case _:
            assert_never(shape)


def first_hits(scene: Scene, state: State, origins: Floats, directions: Floats, max_range: float) -> Hits:
    """First hit of each ray within max_range [m]; origins (r, 3) m and unit directions (r, 3), in W."""
    best: Met = (np.full(len(origins), np.inf), np.zeros_like(origins))
    owner = np.full(len(origins), -1, dtype=np.int64)
    for place, body in enumerate(scene.bodies):
        for placed in body.collision:
            p_WS = state.p_WB[place] + rotate(state.q_WB[place], np.array(placed.p_BS))
            q_WS = product(state.q_WB[place], np.array(placed.q_BS))
            o, d = origins - p_WS, directions
            if turned := bool(q_WS[1:].any()):  # most stand upright
                o, d = rotate_back(q_WS, o), rotate_back(q_WS, d)
            distance, normal = _shape(placed.shape, o, d)
            owner[distance < best[0]] = place
            best = _nearer(best, (distance, rotate(q_WS, normal) if turned else normal))
    beyond = best[0] > max_range
    owner[beyond] = -1
    return Hits(np.where(beyond, np.inf, best[0]), owner, np.where(beyond[:, None], _NO_NORMAL, best[1]))
