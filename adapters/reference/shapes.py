"""Shapes in the engine's words."""

from typing import TYPE_CHECKING, assert_never

from plumbline.harness.scene import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, PlacedShape, Plane, Sphere, TriangleMesh

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["engine_shape"]


def engine_shape(placed: PlacedShape) -> "engine.Placed":
    """A shape at its pose in B."""
    from plumbline import engine

    shape = placed.shape
    made: engine.Shape
    match shape:
        case Sphere():
            made = engine.Sphere(shape.radius)
        case Box():
            made = engine.Box(shape.half_extents)
        case Capsule():
            made = engine.Capsule(shape.radius, shape.half_length)
        case Plane():
            made = engine.Plane(shape.normal)
        case Cylinder():
            made = engine.Cylinder(shape.radius, shape.half_length)
        case Ellipsoid():
            made = engine.Ellipsoid(shape.semi_axes)
        case ConvexHull():
            made = engine.ConvexHull(shape.vertices)
        case TriangleMesh():
            made = engine.TriangleMesh(shape.vertices, shape.faces)
        case _:
            assert_never(shape)
    return engine.Placed(made, placed.p_BS, placed.q_BS)
