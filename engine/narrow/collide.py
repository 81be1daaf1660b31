"""Choose the narrow phase of a pair by the types of its shapes; the lower type is always shape A."""

from engine.compile.jit import kernel
from engine.maths.vec import Ints, Vec
from engine.memory.arena import BOX, CAPSULE, CYLINDER, ELLIPSOID, HULL, PLANE, SPHERE, TYPE
from engine.memory.tables import Shapes
from engine.narrow.box_box import box_box
from engine.narrow.box_pairs import box_plane, capsule_box, sphere_box
from engine.narrow.cylinder_pairs import cylinder_plane, sphere_cylinder
from engine.narrow.ellipsoid_plane import ellipsoid_plane
from engine.narrow.point import Points
from engine.narrow.round_pairs import capsule_capsule, capsule_plane, sphere_capsule, sphere_plane, sphere_sphere
from engine.narrow.solid import solid_of

__all__ = ["UNKNOWN", "collide", "is_convex_pair", "ordered"]

UNKNOWN = -1
"""The number of points of a pair of shapes that has no narrow phase."""


@kernel
def ordered(shape_kind: Ints, one: int, two: int) -> tuple[int, int]:
    """Two shapes, that of the lower type first."""
    return (two, one) if shape_kind[one, TYPE] > shape_kind[two, TYPE] else (one, two)


@kernel
def is_convex_pair(ta: int, tb: int) -> bool:
    """Whether a pair of types, ta <= tb, has no closed form here, so that the convex narrow phase answers it."""
    return tb >= HULL or tb == ELLIPSOID or (tb == CYLINDER and ta != SPHERE)


@kernel
def collide(shapes: Shapes, a: int, b: int, margin: float, out: Points, at: int) -> tuple[int, Vec]:
    """Write the contact points of shapes a and b, type of a <= type of b, from row `at` on.

    Returns: the number of points closer than the margin or UNKNOWN, and the normal from a to b.
    """
    ta, tb = shapes.kind[a, TYPE], shapes.kind[b, TYPE]
    one, two = solid_of(shapes, a), solid_of(shapes, b)
    if ta == SPHERE:
        if tb == SPHERE:
            return sphere_sphere(one, two, margin, out, at)
        if tb == CAPSULE:
            return sphere_capsule(one, two, margin, out, at)
        if tb == BOX:
            return sphere_box(one, two, margin, out, at)
        if tb == CYLINDER:
            return sphere_cylinder(one, two, margin, out, at)
        if tb == PLANE:
            return sphere_plane(one, two, margin, out, at)
    elif ta == CAPSULE:
        if tb == CAPSULE:
            return capsule_capsule(one, two, margin, out, at)
        if tb == BOX:
            return capsule_box(one, two, margin, out, at)
        if tb == PLANE:
            return capsule_plane(one, two, margin, out, at)
    elif ta == BOX:
        if tb == BOX:
            return box_box(one, two, margin, out, at)
        if tb == PLANE:
            return box_plane(one, two, margin, out, at)
    elif ta == CYLINDER and tb == PLANE:
        return cylinder_plane(one, two, margin, out, at)
    elif ta == ELLIPSOID and tb == PLANE:
        return ellipsoid_plane(one, two, margin, out, at)
    return UNKNOWN, (0.0, 0.0, 1.0)
