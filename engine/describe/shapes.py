"""The shapes of bodies, in their own frames, [m]."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, get_args

import numpy as np

from plumbline.engine.describe.check import Described, direction, finite, lengths, positive, unit_quaternion
from plumbline.engine.maths.arrays import norm

FLAT = 1e-12
"""Height of a triangle over its longest edge [1] below which rounding decides where its normal points."""


@dataclass(frozen=True, slots=True)
class Sphere(Described):
    """A ball about the origin."""

    radius: Annotated[float, positive, "m"]


@dataclass(frozen=True, slots=True)
class Box(Described):
    """A cuboid about the origin, |x| <= half_extents[0] and so on."""

    half_extents: Annotated[Sequence[float], lengths]


@dataclass(frozen=True, slots=True)
class Capsule(Described):
    """All points within `radius` of the segment |z| <= half_length."""

    radius: Annotated[float, positive, "m"]
    half_length: Annotated[float, positive, "m"]


@dataclass(frozen=True, slots=True)
class Cylinder(Described):
    """A right circular cylinder about z, |z| <= half_length."""

    radius: Annotated[float, positive, "m"]
    half_length: Annotated[float, positive, "m"]


@dataclass(frozen=True, slots=True)
class Ellipsoid(Described):
    """A solid ellipsoid about the origin, (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1 with the semi-axes (a, b, c)."""

    semi_axes: Annotated[Sequence[float], lengths]


@dataclass(frozen=True, slots=True)
class Plane(Described):
    """The half space normal . x <= 0."""

    normal: Annotated[Sequence[float], direction] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class ConvexHull(Described):
    """The convex hull of vertices (n, 3)."""

    vertices: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        finite("convex hull", "vertices", self.vertices, (len(self.vertices), 3), "m")
        if len(self.vertices) < 4:
            raise ValueError(f"convex hull: {len(self.vertices)} vertices, expected at least 4")


@dataclass(frozen=True, slots=True)
class TriangleMesh(Described):
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


def _shape(element: str, field: str, value: Any) -> None:
    """Raises: ValueError unless it is a shape."""
    if not isinstance(value, Shape):
        raise ValueError(f"{element}: {field} {value!r}, expected one of {', '.join(s.__name__ for s in get_args(Shape))}")


@dataclass(frozen=True, slots=True)
class Placed(Described):
    """A shape at the pose (p_BS, q_BS) relative to the body's centre of mass."""

    ELEMENT: ClassVar[str] = "placed shape"
    shape: Annotated[Shape, _shape]
    p_BS: Annotated[Sequence[float], finite, (3,), "m"] = (0.0, 0.0, 0.0)
    q_BS: Annotated[Sequence[float], unit_quaternion] = (1.0, 0.0, 0.0, 0.0)
