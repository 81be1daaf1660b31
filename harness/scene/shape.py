"""Collision and visual geometry: a closed union of eight shapes, each in its own frame S.

Inertia tensors [kg m2] are those of uniform solids about their centre of mass, in the frame of the shape.
Source: Goldstein, Classical Mechanics, 3rd ed., section 5.3 and exercises.
"""

import math
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Axis, Matrix3, Positive, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Sphere:
    """A ball of `radius` [m] about the origin of S."""

    radius: Positive
    type: Literal["sphere"] = "sphere"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Box:
    """A box of `half_extents` [m] along the axes of S, centred."""

    half_extents: tuple[Positive, Positive, Positive]
    type: Literal["box"] = "box"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Capsule:
    """All points within `radius` [m] of a segment along z, from -half_length to +half_length [m]."""

    radius: Positive
    half_length: Positive
    type: Literal["capsule"] = "capsule"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Cylinder:
    """A solid cylinder along z of `radius` [m], from -half_length to +half_length [m]."""

    radius: Positive
    half_length: Positive
    type: Literal["cylinder"] = "cylinder"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Ellipsoid:
    """A solid ellipsoid of `semi_axes` [m] along the axes of S, centred."""

    semi_axes: tuple[Positive, Positive, Positive]
    type: Literal["ellipsoid"] = "ellipsoid"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Plane:
    """A half space: solid below the plane through the origin of S with the outward `normal` (unit, in S)."""

    normal: Axis = (0.0, 0.0, 1.0)
    type: Literal["plane"] = "plane"


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class ConvexHull:
    """The convex hull of `vertices` [m], shape (n, 3), n >= 4, not all in one plane."""

    vertices: Annotated[tuple[Vector3, ...], Field(min_length=4)]
    type: Literal["convex_hull"] = "convex_hull"

    def __post_init__(self) -> None:
        points = np.asarray(self.vertices)
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[2] <= 1e-9 * spread[0]:
            raise ValueError(f"vertices span no volume (singular values {spread.tolist()}), expected a solid")


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class TriangleMesh:
    """A triangle mesh: `vertices` [m] (n, 3), `faces` (m, 3) counter-clockwise seen from outside."""

    vertices: Annotated[tuple[Vector3, ...], Field(min_length=3)]
    faces: Annotated[tuple[tuple[int, int, int], ...], Field(min_length=1)]
    type: Literal["triangle_mesh"] = "triangle_mesh"

    def __post_init__(self) -> None:
        points, faces = np.asarray(self.vertices), np.asarray(self.faces)
        if faces.min() < 0 or faces.max() >= len(points):
            bad = int(np.flatnonzero(((faces < 0) | (faces >= len(points))).any(axis=1))[0])
            raise ValueError(f"faces[{bad}] = {self.faces[bad]} names a vertex outside 0..{len(points) - 1}")
        a, b, c = (points[faces[:, i]] for i in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        size = np.ptp(points, axis=0).max()
        if (area <= 1e-14 * size * size).any():
            bad = int(np.argmin(area))
            raise ValueError(f"faces[{bad}] = {self.faces[bad]} has no area, expected a proper triangle")


def polyhedron_of(shape: Ellipsoid) -> tuple[Vector3, ...]:
    """Corners [m] (162, 3) on an ellipsoid, of an icosahedron whose edges were halved twice: what stands for it is said to.

    Its faces lie inside the surface by up to 2.7 % of the largest semi-axis.
    """
    import trimesh

    corners = np.array(trimesh.creation.icosphere(subdivisions=2).vertices) * np.array(shape.semi_axes)
    return tuple((float(x), float(y), float(z)) for x, y, z in corners)


def width(shape: "Shape") -> float:
    """The least of a shape's widths along its own axes [m]; infinite for a half space."""
    match shape:
        case Sphere(radius=radius) | Capsule(radius=radius):
            return 2 * radius
        case Cylinder(radius=radius, half_length=half_length):
            return 2 * min(radius, half_length)
        case Box(half_extents=half) | Ellipsoid(semi_axes=half):
            return 2 * min(half)
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            return float(min(max(axis) - min(axis) for axis in zip(*vertices, strict=True)))
        case Plane():
            return math.inf


def outer_radius(shape: "Shape") -> float:
    """Radius [m] of a ball about the origin of S that holds the shape; infinite for a half space."""
    match shape:
        case Sphere(radius=radius):
            return radius
        case Box(half_extents=half):
            return math.hypot(*half)
        case Ellipsoid(semi_axes=semi_axes):
            return max(semi_axes)
        case Capsule(radius=radius, half_length=length):
            return radius + length
        case Cylinder(radius=radius, half_length=length):
            return math.hypot(radius, length)
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            return max(math.hypot(*vertex) for vertex in vertices)
        case Plane():
            return math.inf


LENGTHS = ("radius", "half_length", "half_extents", "semi_axes", "vertices")
"""The fields of shapes that are lengths [m]."""


def scaled_shape(shape: "Shape", size: float) -> "Shape":
    """The shape with all its lengths times `size`; of a half space itself."""
    lengths = {name: (size * np.array(getattr(shape, name))).tolist() for name in LENGTHS if hasattr(shape, name)}
    return replace(shape, **lengths)


Shape = Annotated[
    Sphere | Box | Capsule | Cylinder | Ellipsoid | Plane | ConvexHull | TriangleMesh, Field(discriminator="type")
]


def principal_inertia(xx: float, yy: float, zz: float) -> Matrix3:
    """The diagonal tensor with the principal moments xx, yy, zz [kg m2]."""
    return ((xx, 0.0, 0.0), (0.0, yy, 0.0), (0.0, 0.0, zz))


def sphere_inertia(mass: float, radius: float) -> Matrix3:
    """A solid sphere: 2/5 m r^2."""
    moment = 0.4 * mass * radius**2
    return principal_inertia(moment, moment, moment)


def box_inertia(mass: float, half_extents: Vector3) -> Matrix3:
    """A solid box with half extents (a, b, c): m/3 (b^2 + c^2), ..."""
    a, b, c = half_extents
    return principal_inertia(mass / 3 * (b * b + c * c), mass / 3 * (a * a + c * c), mass / 3 * (a * a + b * b))


def ellipsoid_inertia(mass: float, semi_axes: Vector3) -> Matrix3:
    """A solid ellipsoid with semi-axes (a, b, c): m/5 (b^2 + c^2), ..."""
    a, b, c = semi_axes
    return principal_inertia(mass / 5 * (b * b + c * c), mass / 5 * (a * a + c * c), mass / 5 * (a * a + b * b))


def cylinder_inertia(mass: float, radius: float, half_length: float) -> Matrix3:
    """A solid cylinder along z: m (r^2/4 + h^2/3) across, m r^2/2 along, h the half length."""
    across = mass * (radius**2 / 4 + half_length**2 / 3)
    return principal_inertia(across, across, mass * radius**2 / 2)


def capsule_inertia(mass: float, radius: float, half_length: float) -> Matrix3:
    """A solid capsule along z: a cylinder of half length h between two half balls.

    The half balls' centroids lie 3r/8 beyond the cylinder's ends (parallel-axis theorem).
    """
    cylinder_volume = 2 * half_length * radius**2
    ball_volume = 4 / 3 * radius**3
    m_c = mass * cylinder_volume / (cylinder_volume + ball_volume)
    m_b = mass - m_c
    along = m_c * radius**2 / 2 + m_b * 2 / 5 * radius**2
    across = m_c * (radius**2 / 4 + half_length**2 / 3) + m_b * (
        2 / 5 * radius**2 + half_length**2 + 3 / 4 * half_length * radius
    )
    return principal_inertia(across, across, along)


def solid_inertia(mass: float, shape: Shape) -> Matrix3:
    """A solid of one of the five round or square shapes. Raises: TypeError for another, which has no such formula."""
    match shape:
        case Sphere(radius=radius):
            return sphere_inertia(mass, radius)
        case Box(half_extents=half_extents):
            return box_inertia(mass, half_extents)
        case Ellipsoid(semi_axes=semi_axes):
            return ellipsoid_inertia(mass, semi_axes)
        case Cylinder(radius=radius, half_length=half_length):
            return cylinder_inertia(mass, radius, half_length)
        case Capsule(radius=radius, half_length=half_length):
            return capsule_inertia(mass, radius, half_length)
        case _:
            raise TypeError(f"a {shape.type.replace('_', ' ')} has no inertia of its own, expected it beside the shape")


Floats = npt.NDArray[np.float64]


def support(shape: Shape, ways: Floats) -> Floats:
    """How far [m] a shape that ends reaches from its origin, (...), along unit vectors (..., 3) of its frame.

    Raises: ValueError for a plane.
    """
    match shape:
        case Sphere(radius=radius):
            far = np.full(ways.shape[:-1], radius)
        case Box(half_extents=half):
            far = np.abs(ways) @ np.array(half)
        case Capsule(radius=radius, half_length=length):
            far = radius + length * np.abs(ways[..., 2])
        case Cylinder(radius=radius, half_length=length):
            far = radius * np.hypot(ways[..., 0], ways[..., 1]) + length * np.abs(ways[..., 2])
        case Ellipsoid(semi_axes=semi_axes):
            far = np.linalg.norm(ways * np.array(semi_axes), axis=-1)
        case ConvexHull(vertices=vertices) | TriangleMesh(vertices=vertices):
            far = np.max(np.array(vertices) @ ways.T, axis=0)
        case Plane():
            raise ValueError("a plane reaches without end")
    return np.asarray(far, np.float64)
