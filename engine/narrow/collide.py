"""Choose the narrow phase of a pair by the types of its shapes; the lower type is always shape A."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Ints, Vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Shapes
from plumbline.engine.narrow.box_box import box_box
from plumbline.engine.narrow.box_pairs import box_plane, capsule_box, sphere_box
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.round_pairs import (
    capsule_capsule,
    capsule_plane,
    cylinder_plane,
    ellipsoid_plane,
    sphere_capsule,
    sphere_cylinder,
    sphere_plane,
    sphere_sphere,
)
from plumbline.engine.narrow.solid import solid_of

UNKNOWN = -1
"""The number of points of a pair of shapes that has no narrow phase."""


@kernel
def ordered(shape_kind: Ints, one: int, two: int) -> tuple[int, int]:
    """Two shapes, that of the lower type first."""
    return (two, one) if shape_kind[one, at.TYPE] > shape_kind[two, at.TYPE] else (one, two)


@kernel
def is_convex_pair(ta: int, tb: int) -> bool:
    """Whether a pair of types, ta <= tb, has no closed form here, so that the convex narrow phase answers it."""
    return tb >= at.HULL or tb == at.ELLIPSOID or (tb == at.CYLINDER and ta != at.SPHERE)


@kernel
def collide(shapes: Shapes, a: int, b: int, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Write the contact points of shapes a and b, type of a <= type of b, from row `row` on.

    Returns: the number of points closer than the margin or UNKNOWN, and the normal from a to b.
    """
    ta, tb = shapes.kind[a, at.TYPE], shapes.kind[b, at.TYPE]
    one, two = solid_of(shapes, a), solid_of(shapes, b)
    if ta == at.SPHERE:
        if tb == at.SPHERE:
            return sphere_sphere(one, two, margin, out, row)
        if tb == at.CAPSULE:
            return sphere_capsule(one, two, margin, out, row)
        if tb == at.BOX:
            return sphere_box(one, two, margin, out, row)
        if tb == at.CYLINDER:
            return sphere_cylinder(one, two, margin, out, row)
        if tb == at.PLANE:
            return sphere_plane(one, two, margin, out, row)
    elif ta == at.CAPSULE:
        if tb == at.CAPSULE:
            return capsule_capsule(one, two, margin, out, row)
        if tb == at.BOX:
            return capsule_box(one, two, margin, out, row)
        if tb == at.PLANE:
            return capsule_plane(one, two, margin, out, row)
    elif ta == at.BOX:
        if tb == at.BOX:
            return box_box(one, two, margin, out, row)
        if tb == at.PLANE:
            return box_plane(one, two, margin, out, row)
    elif ta == at.CYLINDER and tb == at.PLANE:
        return cylinder_plane(one, two, margin, out, row)
    elif ta == at.ELLIPSOID and tb == at.PLANE:
        return ellipsoid_plane(one, two, margin, out, row)
    return UNKNOWN, (0.0, 0.0, 1.0)
