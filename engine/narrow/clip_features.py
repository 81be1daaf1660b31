"""Contact points of two features: the incident polygon, line or point clipped by the sides of the reference face.

Source: Ericson, Real-Time Collision Detection, section 8.3.4 (Sutherland-Hodgman); Gregorius, The Separating Axis Test between
Convex Polyhedra, GDC 2013.
"""

import math
from typing import NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, cross, dot, perpendicular, sub
from plumbline.engine.narrow.point import Points, put_point

ON_SIDE = 1e-7
"""Share of the reference face's size [1] within which a corner counts as on its side: it keeps its feature."""
LEVEL = 1e-4
"""Tilt [rad] of an incident feature below which the same corners are kept, whichever is deepest."""
CROSSING = 4096
"""Features of corners that the clipping made count from here."""


class Plane(NamedTuple):
    """A reference face: a point of it, two axes in it, and its outward normal."""

    origin: Vec
    u: Vec
    v: Vec
    n: Vec


@kernel
def flatten(polygon: Floats, row: int, count: int, plane: Plane) -> None:
    """Turn corners from W into two coordinates in the reference plane and the height above it."""
    for k in range(row, row + count):
        x = sub(load3(polygon, k, 0), plane.origin)
        store3(polygon, k, 0, (dot(x, plane.u), dot(x, plane.v), dot(x, plane.n)))


@kernel
def copy_corner(out: Points, corner: int, to: int) -> None:
    """Copy a corner of a polygon to another row."""
    store3(out.polygon, to, 0, load3(out.polygon, corner, 0))
    out.polygon_key[to, 0] = out.polygon_key[corner, 0]


@kernel
def cut_off(out: Points, base: int, count: int, into: int, line: Vec, near: float, feature: int) -> int:
    """Cut a polygon, or two corners as a segment, by the line a x + b y = c, and keep what lies before it.

    Args: base, count: the rows of the polygon; into: where the rest is written; line: (a, b, c), a and b of unit length; near
    [m]: corners so little beyond the line stay; feature: of the corner where the polygon comes back, one more where it leaves.
    Returns: the corners of the rest; -1 where nothing is cut off, and nothing written.
    """
    polygon, kept, cut = out.polygon, 0, False
    for k in range(base, base + count):
        cut = cut or line[0] * polygon[k, 0] + line[1] * polygon[k, 1] - line[2] > near
    if not cut:
        return -1
    for c in range(count):
        a, b = base + c, base + (c + 1) % count
        da = line[0] * polygon[a, 0] + line[1] * polygon[a, 1] - line[2]
        db = line[0] * polygon[b, 0] + line[1] * polygon[b, 1] - line[2]
        if da <= near:
            copy_corner(out, a, into + kept)
            kept += 1
        if (da <= near) != (db <= near) and not (count == 2 and c == 1):
            share, x = min(max(da / (da - db), 0.0), 1.0), load3(polygon, a, 0)
            store3(polygon, into + kept, 0, axpy(share, sub(load3(polygon, b, 0), x), x))
            out.polygon_key[into + kept, 0] = feature + (1 if da <= near else 0)
            kept += 1
    return kept


@kernel
def keep_four(out: Points, base: int, count: int, tie: float) -> int:
    """Keep the deepest point (by more than `tie` [m]), the one farthest from it, and the two that span most area at its sides.

    Args: base, count: the rows of the polygon. Returns: their number.
    """
    clip = out.polygon
    if count <= 4:
        return count
    first = 0
    for c in range(1, count):
        if clip[base + c, 2] < clip[base + first, 2] - tie:
            first = c
    second, far = first, -1.0
    for c in range(count):
        x, y = clip[base + c, 0] - clip[base + first, 0], clip[base + c, 1] - clip[base + first, 1]
        if x * x + y * y > far:
            second, far = c, x * x + y * y
    third, fourth, most, least = first, first, 0.0, 0.0
    ex, ey = clip[base + second, 0] - clip[base + first, 0], clip[base + second, 1] - clip[base + first, 1]
    for c in range(count):
        x, y = clip[base + c, 0] - clip[base + first, 0], clip[base + c, 1] - clip[base + first, 1]
        area = ex * y - ey * x
        if area > most:
            third, most = c, area
        if area < least:
            fourth, least = c, area
    kept = 0
    for c in range(count):
        if c in (first, second, third, fourth):
            copy_corner(out, base + c, base + kept)
            kept += 1
    return kept


@kernel
def put_polygon(
    out: Points, base: int, count: int, plane: Plane, radius: float, margin: float, row: int, marker: int
) -> int:  # fmt: skip
    """Write the points, at most four, of a polygon over a face that are no farther from it than the margin.

    Args: base, count: the rows of the polygon; radius [m] around it; marker: added to every feature. Returns: their number.
    """
    polygon, points, wide = out.polygon, 0, 0.0
    for c in range(base, base + count):
        if polygon[c, 2] - radius <= margin:
            copy_corner(out, c, base + points)
            points += 1
    for c in range(base + 1, base + points):
        wide = max(wide, abs(polygon[c, 0] - polygon[base, 0]), abs(polygon[c, 1] - polygon[base, 1]))
    points = keep_four(out, base, points, LEVEL * wide)
    for c in range(points):
        x, y, height = load3(polygon, base + c, 0)
        gap = height - radius
        place = axpy(x, plane.u, axpy(y, plane.v, axpy(0.5 * gap, plane.n, plane.origin)))
        put_point(out, row + c, place, gap, marker + out.polygon_key[base + c, 0])
    return points


@kernel
def clip_features(sides: int, count: int, n: Vec, radius: float, margin: float, out: Points, row: int, marker: int) -> int:
    """Write the points of the incident feature that lie under the reference face.

    Args: sides: of the reference face, in the first third of the rows of the polygon; count: corners of the incident feature,
    in the second; n: outward normal of the reference face; radius [m] around the incident feature; marker: added to every
    feature.
    Returns: the number of points, at most four.
    """
    polygon, third, size = out.polygon, out.polygon.shape[0] // 3, 0.0
    u = perpendicular(n)
    plane = Plane(load3(polygon, 0, 0), u, cross(n, u), n)
    flatten(polygon, third, count, plane)
    flatten(polygon, 0, sides, plane)
    for k in range(sides):
        size = max(size, abs(polygon[k, 0]), abs(polygon[k, 1]))
    base, into = third, 2 * third
    for side in range(sides):
        (ax, ay, _), (bx, by, _) = load3(polygon, side, 0), load3(polygon, (side + 1) % sides, 0)
        length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        a, b = (by - ay) / length, (ax - bx) / length
        left = cut_off(out, base, count, into, (a, b, a * ax + b * ay), ON_SIDE * size, CROSSING + 2 * side)
        if left >= 0:
            base, into, count = into, base, left
    return put_polygon(out, base, count, plane, radius, margin, row, marker)


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
