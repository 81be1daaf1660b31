"""Contacts of spheres and capsules with each other and with planes.

Source: Ericson, Real-Time Collision Detection, sections 4.5 and 5.1.9 (closest points of two segments).
"""

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints, Vec, along, axpy, cross, dot, norm, scale, sub
from engine.narrow.point import put_point

__all__ = ["capsule_capsule", "capsule_plane", "closest_on_segment", "sphere_capsule", "sphere_plane", "sphere_sphere"]

UP = (0.0, 0.0, 1.0)


@kernel
def sphere_sphere(
    pa: Vec, ra: float, pb: Vec, rb: float, margin: float, point: Floats, key: Ints, at: int, feature: int
) -> tuple[int, Vec]:
    """Sphere A against sphere B. Returns: number of points, normal."""
    d = sub(pb, pa)
    length = norm(d)
    gap = length - ra - rb
    n = along(d, UP)
    if gap > margin:
        return 0, n
    put_point(point, key, at, axpy(ra + 0.5 * gap, n, pa), gap, feature)
    return 1, n


@kernel
def closest_on_segment(p: Vec, centre: Vec, axis: Vec, half: float) -> float:
    """The coordinate along the axis of the point of a segment closest to p."""
    return min(max(dot(sub(p, centre), axis), -half), half)


@kernel
def sphere_capsule(
    pa: Vec, ra: float, pb: Vec, axis: Vec, rb: float, half: float, margin: float, point: Floats, key: Ints, at: int
) -> tuple[int, Vec]:
    """Sphere A against capsule B. Returns: number of points, normal."""
    t = closest_on_segment(pa, pb, axis, half)
    return sphere_sphere(pa, ra, axpy(t, axis, pb), rb, margin, point, key, at, 0)


@kernel
def sphere_plane(
    pa: Vec, ra: float, pb: Vec, up: Vec, margin: float, point: Floats, key: Ints, at: int, feature: int
) -> tuple[int, Vec]:
    """Sphere A against plane B; the normal from A to B is the plane's reversed. Returns: number of points, normal."""
    gap = dot(sub(pa, pb), up) - ra
    n = scale(-1.0, up)
    if gap > margin:
        return 0, n
    put_point(point, key, at, axpy(ra + 0.5 * gap, n, pa), gap, feature)
    return 1, n


@kernel
def capsule_plane(
    pa: Vec, axis: Vec, ra: float, half: float, pb: Vec, up: Vec, margin: float, point: Floats, key: Ints, at: int
) -> tuple[int, Vec]:
    """Capsule A against plane B: a point under each end. Returns: number of points, normal."""
    first, n = sphere_plane(axpy(-half, axis, pa), ra, pb, up, margin, point, key, at, 0)
    second, n = sphere_plane(axpy(half, axis, pa), ra, pb, up, margin, point, key, at + first, 1)
    return first + second, n


@kernel
def capsule_capsule(
    pa: Vec, ua: Vec, ra: float, ha: float, pb: Vec, ub: Vec, rb: float, hb: float, margin: float, point: Floats, key: Ints,
    at: int
) -> tuple[int, Vec]:  # fmt: skip
    """Capsule A against capsule B: one point, or two where their axes run side by side. Returns: number of points, normal."""
    d = sub(pb, pa)
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
                a, b = axpy(s, ua, pa), axpy(t, ub, pb)
                gap = dot(sub(b, a), n) - ra - rb
                if gap <= margin:
                    put_point(point, key, at + count, axpy(ra + 0.5 * gap, n, a), gap, 1 + k)
                    count += 1
            return count, n
    s = 0.0
    if sine2 > 1e-12:
        s = min(max((da - c * db) / sine2, -ha), ha)
    t = min(max(c * s - db, -hb), hb)
    s = min(max(c * t + da, -ha), ha)
    return sphere_sphere(axpy(s, ua, pa), ra, axpy(t, ub, pb), rb, margin, point, key, at, 0)
