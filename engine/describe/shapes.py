"""The shapes of bodies, in their own frames, [m]."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from plumbline.engine.describe.check import direction, finite, positive
from plumbline.engine.maths.arrays import norm

FLAT = 1e-12
"""Height of a triangle over its longest edge [1] below which rounding decides where its normal points."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball about the origin."""

    radius: float

    def __post_init__(self) -> None:
        positive("sphere", "radius", self.radius, "m")


@dataclass(frozen=True, slots=True)
class Box:
    """A cuboid about the origin, |x| <= half_extents[0] and so on."""

    half_extents: Sequence[float]

    def __post_init__(self) -> None:
        finite("box", "half_extents", self.half_extents, (3,), "m")
        for one in self.half_extents:
            positive("box", "half_extents", one, "m")


@dataclass(frozen=True, slots=True)
class Capsule:
    """All points within `radius` of the segment |z| <= half_length."""

    radius: float
    half_length: float

    def __post_init__(self) -> None:
        positive("capsule", "radius", self.radius, "m")
        positive("capsule", "half_length", self.half_length, "m")


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A right circular cylinder about z, |z| <= half_length."""

    radius: float
    half_length: float

    def __post_init__(self) -> None:
        positive("cylinder", "radius", self.radius, "m")
        positive("cylinder", "half_length", self.half_length, "m")


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """A solid ellipsoid about the origin, (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1 with the semi-axes (a, b, c)."""

    semi_axes: Sequence[float]

    def __post_init__(self) -> None:
        finite("ellipsoid", "semi_axes", self.semi_axes, (3,), "m")
        for one in self.semi_axes:
            positive("ellipsoid", "semi_axes", one, "m")


@dataclass(frozen=True, slots=True)
class Plane:
    """The half space normal . x <= 0."""

    normal: Sequence[float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        direction("plane", "normal", self.normal)


@dataclass(frozen=True, slots=True)
class ConvexHull:
    """The convex hull of vertices (n, 3)."""

    vertices: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        finite("convex hull", "vertices", self.vertices, (len(self.vertices), 3), "m")
        if len(self.vertices) < 4:
            raise ValueError(f"convex hull: {len(self.vertices)} vertices, expected at least 4")


@dataclass(frozen=True, slots=True)
class TriangleMesh:
    """A surface of vertices (n, 3) and faces (m, 3), counter-clockwise seen from outside, of a body that forces do not move."""

    vertices: Sequence[Sequence[float]]
    faces: Sequence[Sequence[int]]

    def __post_init__(self) -> None:
        corners = finite("triangle mesh", "vertices", self.vertices, (len(self.vertices), 3), "m")
        faces = np.asarray(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer) or len(faces) == 0:
            raise ValueError(f"triangle mesh: faces have shape {faces.shape}, expected (m, 3) integers, m at least 1")
        if faces.min() < 0 or faces.max() >= len(corners):
            raise ValueError(
                f"triangle mesh: faces name vertices {faces.min()} to {faces.max()}, expected 0 to {len(corners) - 1}"
            )
        a, b, c = (corners[faces[:, k]] for k in range(3))
        edges = np.stack([norm(e) for e in (b - a, c - b, a - c)])
        area = norm(np.cross(b - a, c - a))
        flat = area <= FLAT * np.square(edges.max(axis=0))
        if flat.any():
            face = int(flat.argmax())
            raise ValueError(f"triangle mesh: face {face} of vertices {faces[face].tolist()} has no area")


Shape = Sphere | Box | Capsule | Cylinder | Ellipsoid | Plane | ConvexHull | TriangleMesh


@dataclass(frozen=True, slots=True)
class Placed:
    """A shape at the pose (p_BS, q_BS) relative to the body's centre of mass."""

    shape: Shape
    p_BS: Sequence[float] = (0.0, 0.0, 0.0)
    q_BS: Sequence[float] = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Shape):
            raise ValueError(
                f"placed shape: shape {self.shape!r}, expected one of {', '.join(s.__name__ for s in get_args(Shape))}"
            )
        finite("placed shape", "p_BS", self.p_BS, (3,), "m")
        finite("placed shape", "q_BS", self.q_BS, (4,), "1")
        if float(norm(np.asarray(self.q_BS, float))) < 1e-12:
            raise ValueError(f"placed shape: q_BS {tuple(self.q_BS)} has no direction")
