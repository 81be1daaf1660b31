"""Collision and visual geometry: a closed union of eight shapes, each in its own frame S."""

import math
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Axis, Positive, Vector3


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
