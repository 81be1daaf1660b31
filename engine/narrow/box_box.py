"""Contacts of two boxes: separating axes, then the incident face clipped by the reference face, at most four points kept.

Source: Gottschalk, Lin, Manocha, OBBTree, 1996 (fifteen axes); Ericson, Real-Time Collision Detection, section 5.1.9 (edges)
and 8.3.4 (Sutherland-Hodgman clipping); Gregorius, The Separating Axis Test between Convex Polyhedra, GDC 2013.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Mat, Vec, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, neg, norm, scale, sub, tmat_vec
from plumbline.engine.narrow.clip_features import Plane, cut_off, flatten, put_polygon
from plumbline.engine.narrow.point import Points, put_point
from plumbline.engine.narrow.solid import Solid, column, face_corner, largest

HANDICAP = 1e-3
"""Share of the smallest half extent [1] by which a face of B must beat those of A, and an edge pair all faces.

Where several are as good, the choice stays the same from step to step, and so do the features.
"""
ON_PLANE = 1e-7
"""Share of the largest half extent [1] within which a corner counts as on a clipping plane: it keeps its feature."""
PARALLEL = 1e-8
"""Squared sine of the angle between two edges [1] below which they span no axis."""
EDGES = 10_000
"""Features of edge pairs count from here; those of faces lie below."""
FACE_OF_B = 576
"""Features from here to EDGES belong to a reference face of B; below, the corners of B lie on a face of A."""


@kernel
def between(ma: Mat, mb: Mat) -> Mat:
    """A^T B: entry (i, j) is the cosine between axis i of A and axis j of B."""
    one, two, three = tmat_vec(ma, column(mb, 0)), tmat_vec(ma, column(mb, 1)), tmat_vec(ma, column(mb, 2))
    return one[0], two[0], three[0], one[1], two[1], three[1], one[2], two[2], three[2]


@kernel
def box_box(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Box A against box B."""
    pa, ma, ha = a
    pb, mb, hb = b
    d = sub(pb, pa)
    smallest = min(min(min(ha[0], ha[1]), ha[2]), min(min(hb[0], hb[1]), hb[2]))
    tie = HANDICAP * smallest
    t, c = tmat_vec(ma, d), between(ma, mb)
    u = tmat_vec(mb, d)
    best, code, way = -math.inf, -1, 0.0
    for k in range(3):
        gap = abs(t[k]) - ha[k] - (abs(c[3 * k]) * hb[0] + abs(c[3 * k + 1]) * hb[1] + abs(c[3 * k + 2]) * hb[2])
        if gap > margin:
            return 0, (0.0, 0.0, 1.0)
        if gap > best:
            best, code, way = gap, k, t[k]
    for k in range(3):
        gap = abs(u[k]) - hb[k] - (abs(c[k]) * ha[0] + abs(c[3 + k]) * ha[1] + abs(c[6 + k]) * ha[2])
        if gap > margin:
            return 0, (0.0, 0.0, 1.0)
        if gap > best + tie:
            best, code, way = gap, 3 + k, u[k]
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            along = t[i2] * c[3 * i1 + j] - t[i1] * c[3 * i2 + j]
            gap = abs(along) - (ha[i1] * abs(c[3 * i2 + j]) + ha[i2] * abs(c[3 * i1 + j]))
            gap -= hb[j1] * abs(c[3 * i + j2]) + hb[j2] * abs(c[3 * i + j1])
            # The axis is not of unit length yet: what it will be divided by is at most one, so that a depth can only grow.
            if gap <= min(min(best + tie, margin), 0.0):
                continue
            square = 1.0 - c[3 * i + j] * c[3 * i + j]
            if square < PARALLEL:
                continue
            gap /= math.sqrt(square)
            if gap > margin:
                return 0, (0.0, 0.0, 1.0)
            if gap > best + tie:
                best, code, way = gap, 6 + 3 * i + j, along
    if code >= 6:
        i, j = (code - 6) // 3, (code - 6) % 3
        n = cross(column(ma, i), column(mb, j))
        normal = scale(math.copysign(1.0 / norm(n), way), n)
        return edge_edge(a, b, code, normal, best, out, row), normal
    reference, incident = (a, b) if code < 3 else (b, a)
    normal = scale(1.0 if way >= 0.0 else -1.0, column(reference.m, code % 3))
    outward = normal if code < 3 else neg(normal)
    return face_face(reference, incident, code, outward, margin, out, row), normal


@kernel
def edge_edge(a: Solid, b: Solid, code: int, n: Vec, gap: float, out: Points, row: int) -> int:
    """One point, midway between the two edges that face each other along n.

    Args: code: 6 + 3 i + j, where n is the cross product of axis i of A and axis j of B. Returns: the number of points.
    """
    i, j = (code - 6) // 3, (code - 6) % 3
    x, ma, ha = a
    y, mb, hb = b
    for k in range(3):
        if k != i:
            x = axpy(math.copysign(ha[k], dot(column(ma, k), n)), column(ma, k), x)
        if k != j:
            y = axpy(-math.copysign(hb[k], dot(column(mb, k), n)), column(mb, k), y)
    ua, ub = column(ma, i), column(mb, j)
    c = dot(ua, ub)
    d = sub(y, x)
    s = (dot(d, ua) - c * dot(d, ub)) / (1.0 - c * c)
    t = (c * dot(d, ua) - dot(d, ub)) / (1.0 - c * c)
    s, t = min(max(s, -ha[i]), ha[i]), min(max(t, -hb[j]), hb[j])
    place = scale(0.5, add(axpy(s, ua, x), axpy(t, ub, y)))
    put_point(out, row, place, gap, EDGES + code)
    return 1


@kernel
def face_face(reference: Solid, incident: Solid, code: int, n: Vec, margin: float, out: Points, row: int) -> int:
    """Points of the incident box under the face of the reference box whose outward normal is n.

    Args: code: the axis of that face, and 3 more if it is one of B. Returns: the number of points.
    """
    pr, mr, hr = reference
    pi, mi, hi = incident
    face = code % 3
    one, two = (face + 1) % 3, (face + 2) % 3
    plane = Plane(axpy(hr[face], n, pr), column(mr, one), column(mr, two), n)
    local = tmat_vec(mi, n)
    facing = largest(local)
    sign = -1.0 if local[facing] > 0.0 else 1.0
    for corner in range(4):
        store3(out.polygon, corner, 0, face_corner(pi, mi, hi, facing, sign, corner))
        out.polygon_key[corner, 0] = corner
    flatten(out.polygon, 0, 4, plane)
    count, base = 4, 0
    near = ON_PLANE * max(hr[one], hr[two])
    for side in range(4):
        way = 1.0 if side % 2 == 0 else -1.0
        line = (way, 0.0, hr[one]) if side < 2 else (0.0, way, hr[two])
        left = cut_off(out, base, count, 16 - base, line, near, 8 + 2 * side)
        if left >= 0:
            base, count = 16 - base, left
    marker = 32 * (2 * (3 * code + facing) + (1 if sign > 0.0 else 0))
    return put_polygon(out, base, count, plane, 0.0, margin, row, marker)
