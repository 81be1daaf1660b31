"""Contacts of round shapes in closed form: spheres, capsules, cylinders and ellipsoids with each other and with planes.

Source: Ericson, Real-Time Collision Detection, sections 3.8 (support mappings), 4.5, 5.1 (closest points) and 5.1.9 (of two
segments); Kodam et al., Chem. Eng. Sci. 65, 2010 (cylinder contact cases); Rockafellar, Convex Analysis, 1970, section 13 (the
support function |D n| of an ellipsoid).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec
from plumbline.engine.maths.vec import add, along, axpy, cross, dot, mat_vec, neg, norm, scale, sub, tmat_vec
from plumbline.engine.narrow.point import Points, put_nearest, put_point
from plumbline.engine.narrow.solid import Solid, axis_of, moved
from plumbline.engine.narrow.support import ellipsoid_support

UP = (0.0, 0.0, 1.0)


@kernel
def sphere_sphere(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Sphere A against sphere B."""
    ra, rb = a.size[0], b.size[0]
    d = sub(b.p, a.p)
    return put_nearest(out, row, a.p, ra, along(d, UP), norm(d) - ra - rb, margin)


@kernel
def closest_on_segment(p: Vec, centre: Vec, axis: Vec, half: float) -> float:
    """The coordinate along the axis of the point of a segment closest to p."""
    return min(max(dot(sub(p, centre), axis), -half), half)


@kernel
def sphere_capsule(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Sphere A against capsule B: against the sphere about the closest point of its axis."""
    axis = axis_of(b)
    t = closest_on_segment(a.p, b.p, axis, b.size[1])
    return sphere_sphere(a, moved(b, axpy(t, axis, b.p)), margin, out, row)


@kernel
def sphere_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Sphere A against plane B; the normal from A to B is the plane's reversed."""
    up, ra = axis_of(b), a.size[0]
    return put_nearest(out, row, a.p, ra, neg(up), dot(sub(a.p, b.p), up) - ra, margin)


@kernel
def capsule_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Capsule A against plane B: a point under each end."""
    up, axis, ra = axis_of(b), axis_of(a), a.size[0]
    n = scale(-1.0, up)
    count = 0
    for k in range(2):
        end = axpy(-a.size[1] if k == 0 else a.size[1], axis, a.p)
        gap = dot(sub(end, b.p), up) - ra
        if gap <= margin:
            put_point(out, row + count, axpy(ra + 0.5 * gap, n, end), gap, k)
            count += 1
    return count, n


@kernel
def capsule_capsule(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Capsule A against capsule B: one point, or two where their axes run side by side."""
    ua, ub = axis_of(a), axis_of(b)
    ra, ha, rb, hb = a.size[0], a.size[1], b.size[0], b.size[1]
    d = sub(b.p, a.p)
    c = dot(ua, ub)
    da, db = dot(d, ua), dot(d, ub)
    sine2 = 1.0 - c * c
    if sine2 < 1e-4:
        sign = 1.0 if c > 0.0 else -1.0
        low, high = max(-ha, da - hb), min(ha, da + hb)
        if high > low:
            side = axpy(-da, ua, d)
            n = along(side, along(cross(ua, UP), (1.0, 0.0, 0.0)))
            count = 0
            for k in range(2):
                s = low if k == 0 else high
                t = min(max(sign * (s - da), -hb), hb)
                x, y = axpy(s, ua, a.p), axpy(t, ub, b.p)
                gap = dot(sub(y, x), n) - ra - rb
                if gap <= margin:
                    put_point(out, row + count, axpy(ra + 0.5 * gap, n, x), gap, 1 + k)
                    count += 1
            return count, n
    s = 0.0
    if sine2 > 1e-12:
        s = min(max((da - c * db) / sine2, -ha), ha)
    t = min(max(c * s - db, -hb), hb)
    s = min(max(c * t + da, -ha), ha)
    return sphere_sphere(moved(a, axpy(s, ua, a.p)), moved(b, axpy(t, ub, b.p)), margin, out, row)


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
    return put_nearest(out, row, a.p, ra, neg(mat_vec(b.m, outward)), distance - ra, margin)


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
    rims, count = (lowest, lowest, beside, neg(beside), neg(lowest)), 0
    for k in range(5):
        end = -side if k == 1 else side
        place = add(axpy(end * half, axis, a.p), scale(ra, rims[k]))
        gap = dot(sub(place, b.p), up)
        if gap <= margin and count < 4:
            put_point(out, row + count, axpy(0.5 * gap, n, place), gap, 2 * k + (1 if end > 0.0 else 0))
            count += 1
    return count, n


@kernel
def ellipsoid_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Ellipsoid A against plane B; the normal from A to B is the plane's reversed."""
    up = axis_of(b)
    n = neg(up)
    lowest = add(a.p, mat_vec(a.m, ellipsoid_support(a.size, tmat_vec(a.m, n))))
    return put_nearest(out, row, lowest, 0.0, n, dot(sub(lowest, b.p), up), margin)
