"""Bounding volumes tighter than an axis-aligned box: spheres for round pairs, oriented boxes for long and flat ones.

The axis-aligned box is what trees, grids and sorted axes are made of; of the pairs that it leaves, the sphere removes those
that meet at corners of boxes only, and the oriented box those of long shapes that lie askew.

Source: Ericson, Real-Time Collision Detection, sections 4.3 (spheres) and 4.4.1 (oriented boxes, separating axes).
"""

from engine.arena import CAPSULE, CYLINDER, PLANE, SIZE, SPHERE, TYPE
from engine.jit import kernel
from engine.vec import Floats, Ints, Vec, dot, load3, load9, sub, tmat_vec

__all__ = ["volumes_apart"]


@kernel
def reach_along(shape: Floats, shape_kind: Ints, pose: Floats, s: int, n: Vec) -> float:
    """Half the width [m] along the unit vector n of the sphere, or of the oriented box about a bounded shape."""
    h, kind = load3(shape, s, SIZE), shape_kind[s, TYPE]
    if kind == SPHERE:
        return h[0]
    if kind == CAPSULE:
        h = (h[0], h[0], h[0] + h[1])
    elif kind == CYLINDER:
        h = (h[0], h[0], h[1])
    local = tmat_vec(load9(pose, s, 3), n)
    return h[0] * abs(local[0]) + h[1] * abs(local[1]) + h[2] * abs(local[2])


@kernel
def volumes_apart(shape: Floats, shape_kind: Ints, pose: Floats, bounds: Floats, i: int, j: int) -> bool:
    """Whether the widened spheres of two spheres, or the widened oriented boxes of two other shapes, do not overlap.

    Of the oriented boxes the six face normals are tried; the edges are left to the narrow phase.
    """
    one, two = shape_kind[i, TYPE], shape_kind[j, TYPE]
    if one == PLANE or two == PLANE:
        return False
    d, grow = sub(load3(pose, j, 0), load3(pose, i, 0)), bounds[i, 6] + bounds[j, 6]
    if one == SPHERE and two == SPHERE:
        r = shape[i, SIZE] + shape[j, SIZE] + grow
        return bool(dot(d, d) > r * r)
    for k in range(6):
        s, c = (i, 3 + k) if k < 3 else (j, k)
        if shape_kind[s, TYPE] == SPHERE:
            continue
        n = (pose[s, c], pose[s, c + 3], pose[s, c + 6])
        reach = reach_along(shape, shape_kind, pose, i, n) + reach_along(shape, shape_kind, pose, j, n)
        if abs(dot(d, n)) > reach + grow:
            return True
    return False
