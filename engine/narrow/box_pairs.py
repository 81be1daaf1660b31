"""Contacts of a box with a sphere, a capsule and a plane.

Source: Ericson, Real-Time Collision Detection, sections 5.1.3 (closest point of a box), 5.2.3 (box and plane).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec
from plumbline.engine.maths.vec import axpy, dot, mat_vec, neg, norm, scale, sub, tmat_vec
from plumbline.engine.narrow.point import Points, put_nearest, put_point
from plumbline.engine.narrow.solid import Solid, axis_of, face_corner, largest, moved


@kernel
def clamp3(p: Vec, h: Vec) -> Vec:
    """The point of the box |x| <= h closest to p."""
    return min(max(p[0], -h[0]), h[0]), min(max(p[1], -h[1]), h[1]), min(max(p[2], -h[2]), h[2])


@kernel
def nearest_face(p: Vec, h: Vec) -> tuple[Vec, float]:
    """For p inside the box: the outward normal of the nearest face, and the distance to it."""
    x, y, z = h[0] - abs(p[0]), h[1] - abs(p[1]), h[2] - abs(p[2])
    if x <= y and x <= z:
        return (math.copysign(1.0, p[0]), 0.0, 0.0), x
    if y <= z:
        return (0.0, math.copysign(1.0, p[1]), 0.0), y
    return (0.0, 0.0, math.copysign(1.0, p[2])), z


@kernel
def sphere_box(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Sphere A against box B."""
    ra, h = a.size[0], b.size
    p = tmat_vec(b.m, sub(a.p, b.p))
    d = sub(p, clamp3(p, h))
    length = norm(d)
    if length > 1e-12:
        outward, distance = scale(1.0 / length, d), length
    else:
        outward, depth = nearest_face(p, h)
        distance = -depth
    return put_nearest(out, row, a.p, ra, neg(mat_vec(b.m, outward)), distance - ra, margin)


@kernel
def slope_at(p: Vec, u: Vec, h: Vec, t: float) -> float:
    """Half the derivative of the squared distance from the box to p + t u; it grows with t."""
    x = axpy(t, u, p)
    return dot(u, sub(x, clamp3(x, h)))


@kernel
def closest_on_axis(p: Vec, u: Vec, half: float, h: Vec) -> float:
    """The coordinate t, |t| <= half, where p + t u is closest to the box: the zero of a piecewise linear, growing slope."""
    low, high = -half, half
    if slope_at(p, u, h, low) >= 0.0:
        return low
    if slope_at(p, u, h, high) <= 0.0:
        return high
    for k in range(3):
        for sign in (-1.0, 1.0):
            if abs(u[k]) > 1e-12:
                t = (sign * h[k] - p[k]) / u[k]
                if low < t < high:
                    if slope_at(p, u, h, t) < 0.0:
                        low = t
                    else:
                        high = t
    a, b = slope_at(p, u, h, low), slope_at(p, u, h, high)
    if b - a < 1e-300:
        return 0.5 * (low + high)
    return low - a * (high - low) / (b - a)


@kernel
def capsule_box(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Capsule A against box B: the ends of the part of its axis that lies over the touched face, or the closest point."""
    axis, ra, half, h = axis_of(a), a.size[0], a.size[1], b.size
    p, u = tmat_vec(b.m, sub(a.p, b.p)), tmat_vec(b.m, axis)
    t = closest_on_axis(p, u, half, h)
    x = axpy(t, u, p)
    d = sub(x, clamp3(x, h))
    length = norm(d)
    if length - ra > margin:
        return 0, (0.0, 0.0, 1.0)
    outward = scale(1.0 / length, d) if length > 1e-12 else deepest_axis(p, u, half, h)
    face = -1
    for k in range(3):
        if abs(outward[k]) > 0.999:
            face = k
    if face >= 0:
        sign = math.copysign(1.0, outward[face])
        outward = (sign if face == 0 else 0.0, sign if face == 1 else 0.0, sign if face == 2 else 0.0)
        low, high = -half, half
        for k in range(3):
            if k != face and abs(u[k]) > 1e-12:
                one, two = (-h[k] - p[k]) / u[k], (h[k] - p[k]) / u[k]
                low, high = max(low, min(one, two)), min(high, max(one, two))
        if high > low:
            n = neg(mat_vec(b.m, outward))
            count = 0
            for end in range(2):
                s = low if end == 0 else high
                y = axpy(s, u, p)
                gap = sign * y[face] - h[face] - ra
                if gap <= margin:
                    put_point(out, row + count, axpy(ra + 0.5 * gap, n, axpy(s, axis, a.p)), gap, 1 + end)
                    count += 1
            return count, n
    return sphere_box(moved(a, axpy(t, axis, a.p)), b, margin, out, row)


@kernel
def deepest_axis(p: Vec, u: Vec, half: float, h: Vec) -> Vec:
    """For an axis that pierces the box: the outward face normal along which the least way separates them."""
    best, outward = math.inf, (0.0, 0.0, 1.0)
    for k in range(3):
        reach = half * abs(u[k])
        for sign in (-1.0, 1.0):
            way = h[k] + reach - sign * p[k]
            if way < best:
                best = way
                outward = (sign if k == 0 else 0.0, sign if k == 1 else 0.0, sign if k == 2 else 0.0)
    return outward


@kernel
def box_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Box A against plane B: the corners of the face that looks most at the plane."""
    up, h = axis_of(b), a.size
    u = tmat_vec(a.m, up)
    face = largest(u)
    low = -1.0 if u[face] > 0.0 else 1.0
    count = 0
    n = neg(up)
    for corner in range(4):
        place = face_corner(a.p, a.m, h, face, low, corner)
        gap = dot(sub(place, b.p), up)
        if gap <= margin:
            put_point(out, row + count, axpy(0.5 * gap, n, place), gap, 8 * face + (4 if low > 0.0 else 0) + corner)
            count += 1
    return count, n
