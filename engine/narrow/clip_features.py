"""Contact points of two features: the incident polygon, line or point clipped by the sides of the reference face.

Source: Ericson, Real-Time Collision Detection, section 8.3.4 (Sutherland-Hodgman); Gregorius, The Separating Axis Test between
Convex Polyhedra, GDC 2013.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec, load3
from plumbline.engine.maths.vec import axpy, cross, dot, perpendicular, sub
from plumbline.engine.narrow.box_box import keep_four
from plumbline.engine.narrow.point import Points, put_point

ON_SIDE = 1e-7
"""Share of the reference face's size [1] within which a corner counts as on its side: it keeps its feature."""
LEVEL = 1e-4
"""Tilt [rad] of an incident feature below which the same corners are kept, whichever is deepest."""
CROSSING = 4096
"""Features of corners that the clipping made count from here."""


@kernel
def flatten(polygon: Floats, row: int, count: int, origin: Vec, u: Vec, v: Vec, n: Vec) -> None:
    """Turn corners from W into two coordinates in the reference plane and the height above it."""
    for k in range(row, row + count):
        x = sub(load3(polygon, k, 0), origin)
        polygon[k, 0], polygon[k, 1], polygon[k, 2] = dot(x, u), dot(x, v), dot(x, n)


@kernel
def clip_features(sides: int, count: int, n: Vec, radius: float, margin: float, out: Points, row: int, marker: int) -> int:
    """Write the points of the incident feature that lie under the reference face.

    Args: sides: of the reference face, in the first third of the rows of the polygon; count: corners of the incident feature,
    in the second; n: outward normal of the reference face; radius [m] around the incident feature; marker: added to every
    feature.
    Returns: the number of points, at most four.
    """
    polygon, key = out.polygon, out.polygon_key
    third = polygon.shape[0] // 3
    origin = load3(polygon, 0, 0)
    u = perpendicular(n)
    v = cross(n, u)
    flatten(polygon, third, count, origin, u, v, n)
    flatten(polygon, 0, sides, origin, u, v, n)
    size = 0.0
    for k in range(sides):
        size = max(size, abs(polygon[k, 0]), abs(polygon[k, 1]))
    near, base, into = ON_SIDE * size, third, 2 * third
    for side in range(sides):
        after = (side + 1) % sides
        ex, ey = polygon[after, 0] - polygon[side, 0], polygon[after, 1] - polygon[side, 1]
        length = math.sqrt(ex * ex + ey * ey)
        kept = 0
        for c in range(count):
            a, b = base + c, base + (c + 1) % count
            da = (ey * (polygon[a, 0] - polygon[side, 0]) - ex * (polygon[a, 1] - polygon[side, 1])) / length
            db = (ey * (polygon[b, 0] - polygon[side, 0]) - ex * (polygon[b, 1] - polygon[side, 1])) / length
            if da <= near:
                for m in range(3):
                    polygon[into + kept, m] = polygon[a, m]
                key[into + kept, 0] = key[a, 0]
                kept += 1
            if (da <= near) != (db <= near) and not (count == 2 and c == 1):
                share = min(max(da / (da - db), 0.0), 1.0)
                for m in range(3):
                    polygon[into + kept, m] = polygon[a, m] + share * (polygon[b, m] - polygon[a, m])
                key[into + kept, 0] = CROSSING + 2 * side + (1 if da <= near else 0)
                kept += 1
        base, into, count = into, base, kept
        if count == 0:
            return 0
    points = 0
    for c in range(count):
        if polygon[base + c, 2] - radius <= margin:
            for m in range(3):
                polygon[base + points, m] = polygon[base + c, m]
            key[base + points, 0] = key[base + c, 0]
            points += 1
    wide = 0.0
    for c in range(1, points):
        wide = max(wide, abs(polygon[base + c, 0] - polygon[base, 0]), abs(polygon[base + c, 1] - polygon[base, 1]))
    points = keep_four(out, base, points, LEVEL * wide)
    for c in range(points):
        gap = polygon[base + c, 2] - radius
        place = axpy(polygon[base + c, 0], u, axpy(polygon[base + c, 1], v, axpy(0.5 * gap, n, origin)))
        put_point(out, row + c, place, gap, marker + key[base + c, 0])
    return points


@kernel
def crossing_lines(n: Vec, ra: float, rb: float, margin: float, out: Points, row: int) -> int:
    """The two ends of the common part of two parallel lines, of A in the first rows, of B in the second third of the polygon.

    Args: n: normal from A to B; ra, rb [m]: radii around the lines.
    Returns: the number of points, 0 where the lines are not parallel.
    """
    polygon = out.polygon
    third = polygon.shape[0] // 3
    a, b = load3(polygon, 0, 0), load3(polygon, third, 0)
    ea, eb = sub(load3(polygon, 1, 0), a), sub(load3(polygon, third + 1, 0), b)
    la, lb = math.sqrt(dot(ea, ea)), math.sqrt(dot(eb, eb))
    across = cross(ea, eb)
    if math.sqrt(dot(across, across)) > 1e-3 * la * lb:
        return 0
    one, two = dot(sub(b, a), ea) / (la * la), dot(sub(axpy(1.0, eb, b), a), ea) / (la * la)
    low, high = max(0.0, min(one, two)), min(1.0, max(one, two))
    if high <= low:
        return 0
    points = 0
    for k in range(2):
        s = low if k == 0 else high
        x = axpy(s, ea, a)
        other = axpy((s - one) / (two - one), eb, b)
        gap = dot(sub(other, x), n) - ra - rb
        if gap <= margin:
            put_point(out, row + points, axpy(ra + 0.5 * gap, n, x), gap, 1 + k)
            points += 1
    return points
