"""Contacts of a cylinder with a sphere and with a plane.

Source: Ericson, Real-Time Collision Detection, section 5.1 (closest points); Kodam et al., Chem. Eng. Sci. 65, 2010 (cylinder
contact cases).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, neg, norm, scale, sub, tmat_vec
from plumbline.engine.narrow.point import Points, put_point
from plumbline.engine.narrow.solid import Solid, axis_of

UPRIGHT = 1e-3
"""Sine of the tilt below which a cylinder stands on the same four points of its rim, whichever of them is lowest."""


@kernel
def sphere_cylinder(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Sphere A against cylinder B."""
    ra, rb, half = a.size[0], b.size[0], b.size[1]
    p = tmat_vec(b.m, sub(a.p, b.p))
    axial = math.sqrt(p[0] * p[0] + p[1] * p[1])
    shrink = min(1.0, rb / max(axial, 1e-300))
    d = sub(p, (p[0] * shrink, p[1] * shrink, min(max(p[2], -half), half)))
    length = norm(d)
    if length > 1e-12:
        outward, distance = scale(1.0 / length, d), length
    elif rb - axial < half - abs(p[2]):
        outward, distance = (p[0] / max(axial, 1e-300), p[1] / max(axial, 1e-300), 0.0), axial - rb
    else:
        outward, distance = (0.0, 0.0, math.copysign(1.0, p[2])), abs(p[2]) - half
    n = neg(mat_vec(b.m, outward))
    gap = distance - ra
    if gap > margin:
        return 0, n
    put_point(out, row, axpy(ra + 0.5 * gap, n, a.p), gap, 0)
    return 1, n


@kernel
def cylinder_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Cylinder A against plane B: the lowest points of both rims, and three more of the lower one where it stands."""
    axis, up, ra, half = axis_of(a), axis_of(b), a.size[0], a.size[1]
    n = neg(up)
    fall = sub(n, scale(dot(n, axis), axis))
    sine = norm(fall)
    lowest = scale(1.0 / sine, fall) if sine > UPRIGHT else (a.m[0], a.m[3], a.m[6])
    beside = cross(axis, lowest)
    side = 1.0 if dot(axis, n) >= 0.0 else -1.0
    count = 0
    for k in range(5):
        end = -side if k == 1 else side
        if k <= 1:
            rim = lowest
        elif k == 2:
            rim = beside
        elif k == 3:
            rim = neg(beside)
        else:
            rim = neg(lowest)
        place = add(axpy(end * half, axis, a.p), scale(ra, rim))
        gap = dot(sub(place, b.p), up)
        if gap <= margin and count < 4:
            put_point(out, row + count, axpy(0.5 * gap, n, place), gap, 2 * k + (1 if end > 0.0 else 0))
            count += 1
    return count, n
