"""Choose the narrow phase of a pair by the types of its shapes; the lower type is always shape A."""

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints, Vec, load3, load9
from engine.memory.arena import BOX, CAPSULE, CYLINDER, HULL, PLANE, SIZE, SPHERE, TYPE
from engine.narrow.box_box import box_box
from engine.narrow.box_pairs import box_plane, capsule_box, sphere_box
from engine.narrow.cylinder_pairs import cylinder_plane, sphere_cylinder
from engine.narrow.round_pairs import capsule_capsule, capsule_plane, sphere_capsule, sphere_plane, sphere_sphere

__all__ = ["UNKNOWN", "collide", "is_convex_pair"]

UNKNOWN = -1
"""The number of points of a pair of shapes that has no narrow phase."""


@kernel
def is_convex_pair(ta: int, tb: int) -> bool:
    """Whether a pair of types, ta <= tb, has no closed form here, so that the convex narrow phase answers it."""
    return tb >= HULL or (tb == CYLINDER and ta != SPHERE)


@kernel
def collide(
    shape: Floats, shape_kind: Ints, pose: Floats, a: int, b: int, margin: float, point: Floats, key: Ints, at: int,
    clip: Floats, clip_key: Ints,
) -> tuple[int, Vec]:  # fmt: skip
    """Write the contact points of shapes a and b, type of a <= type of b, from row `at` on.

    Returns: the number of points closer than the margin or UNKNOWN, and the normal from a to b.
    """
    ta, tb = shape_kind[a, TYPE], shape_kind[b, TYPE]
    pa, pb = load3(pose, a, 0), load3(pose, b, 0)
    ma, mb = load9(pose, a, 3), load9(pose, b, 3)
    sa, sb = load3(shape, a, SIZE), load3(shape, b, SIZE)
    za, zb = (ma[2], ma[5], ma[8]), (mb[2], mb[5], mb[8])
    if ta == SPHERE:
        if tb == SPHERE:
            return sphere_sphere(pa, sa[0], pb, sb[0], margin, point, key, at, 0)
        if tb == CAPSULE:
            return sphere_capsule(pa, sa[0], pb, zb, sb[0], sb[1], margin, point, key, at)
        if tb == BOX:
            return sphere_box(pa, sa[0], pb, mb, sb, margin, point, key, at, 0)
        if tb == CYLINDER:
            return sphere_cylinder(pa, sa[0], pb, mb, sb[0], sb[1], margin, point, key, at)
        if tb == PLANE:
            return sphere_plane(pa, sa[0], pb, zb, margin, point, key, at, 0)
    elif ta == CAPSULE:
        if tb == CAPSULE:
            return capsule_capsule(pa, za, sa[0], sa[1], pb, zb, sb[0], sb[1], margin, point, key, at)
        if tb == BOX:
            return capsule_box(pa, za, sa[0], sa[1], pb, mb, sb, margin, point, key, at)
        if tb == PLANE:
            return capsule_plane(pa, za, sa[0], sa[1], pb, zb, margin, point, key, at)
    elif ta == BOX:
        if tb == BOX:
            return box_box(pa, ma, sa, pb, mb, sb, margin, point, key, at, clip, clip_key)
        if tb == PLANE:
            return box_plane(pa, ma, sa, pb, zb, margin, point, key, at)
    elif ta == CYLINDER and tb == PLANE:
        return cylinder_plane(pa, ma, sa[0], sa[1], pb, zb, margin, point, key, at)
    return UNKNOWN, (0.0, 0.0, 1.0)
