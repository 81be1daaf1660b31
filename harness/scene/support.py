"""The support function of shapes: how far each reaches along a direction."""

import numpy as np
import numpy.typing as npt

from plumbline.harness.scene.shape import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere, TriangleMesh

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
