"""Whether two triangles meet, and along which segment: two intervals on the line that their planes have in common.

Every decision is the sign of a determinant of differences of corners: nothing is divided before the answer is known, so that
it is exact wherever these products are, as of corners on a lattice. Triangles in one plane, and one without an area, are told
as such: they have no one segment in common, and their distance says the rest.

Source: Moller, A Fast Triangle-Triangle Intersection Test, Journal of Graphics Tools 2(2), 1997 (the intervals); Guigue,
Devillers, Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates, Journal of Graphics Tools 8(1), 2003.
"""

from typing import Final

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Mat, Vec
from plumbline.engine.maths.vec import axpy, cross, dot, sub

APART: Final = 0
CROSSING: Final = 1  # along a segment, perhaps a point
FLAT: Final = 2  # in one plane, or one of them has no area: whether they meet is not told
EDGES_OF_B: Final = 3  # edge k of B, from its corner k to the next, is told as this plus k
NOWHERE: Final = (0.0, 0.0, 0.0)


@kernel
def corner(t: Mat, k: int) -> Vec:
    """Corner k of a triangle whose corners are its rows; k goes round."""
    k = k % 3
    if k == 0:
        return t[0], t[1], t[2]
    return (t[3], t[4], t[5]) if k == 1 else (t[6], t[7], t[8])


@kernel
def orientation(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """Six times the volume [m3] of a tetrahedron: positive where d lies where the normal of a, b, c points."""
    return dot(cross(sub(b, a), sub(c, a)), sub(d, a))


@kernel
def heights(t: Mat, other: Mat) -> Vec:
    """The corners of another triangle over the plane of t, each height times twice the area of t [m3]."""
    a, b, c = corner(t, 0), corner(t, 1), corner(t, 2)
    n = cross(sub(b, a), sub(c, a))
    return dot(n, sub(corner(other, 0), a)), dot(n, sub(corner(other, 1), a)), dot(n, sub(corner(other, 2), a))


@kernel
def one_side(h: Vec) -> bool:
    """Whether all heights are above zero, or all below."""
    return (h[0] > 0.0 and h[1] > 0.0 and h[2] > 0.0) or (h[0] < 0.0 and h[1] < 0.0 and h[2] < 0.0)


@kernel
def alone(h: Vec) -> tuple[int, float]:
    """The corner with the other two beyond the plane or on it, and the side that it is on: 1 above, -1 below.

    Args: h: heights, not all zero and not all on one side.
    """
    for k in range(3):
        one, two, three = h[k], h[(k + 1) % 3], h[(k + 2) % 3]
        if one > 0.0 and two <= 0.0 and three <= 0.0:
            return k, 1.0
        if one < 0.0 and two >= 0.0 and three >= 0.0:
            return k, -1.0
    # Only a corner in the plane is left, with the other two on one side of it.
    for k in range(3):
        if h[k] == 0.0:
            return k, -1.0 if h[(k + 1) % 3] > 0.0 else 1.0
    return 0, 1.0


@kernel
def edge_between(i: int, j: int) -> int:
    """The edge between two corners."""
    return i if (i + 1) % 3 == j else j


@kernel
def cut(t: Mat, h: Vec, i: int, j: int) -> Vec:
    """Where the edge from corner i to corner j meets the plane over which they have the heights h."""
    a = corner(t, i)
    return axpy(h[i] / (h[i] - h[j]), sub(corner(t, j), a), a)


@kernel
def triangle_triangle(a: Mat, b: Mat) -> tuple[int, Vec, Vec, int, int]:
    """How triangles A and B, each with its corners as rows [m], meet.

    Returns: APART, CROSSING or FLAT; where they cross, the two ends of the segment [m] and the edge on which each lies: of A,
    or of B with EDGES_OF_B added.
    """
    ha = heights(b, a)
    if one_side(ha):
        return APART, NOWHERE, NOWHERE, 0, 0
    hb = heights(a, b)
    if one_side(hb):
        return APART, NOWHERE, NOWHERE, 0, 0
    if ha == NOWHERE or hb == NOWHERE:
        return FLAT, NOWHERE, NOWHERE, 0, 0
    p0, above_b = alone(ha)
    q0, above_a = alone(hb)
    # Along n_A x n_B the interval of A goes from p0 p2 to p0 p1, that of B from q0 q1 to q0 q2.
    p1, p2 = ((p0 + 1) % 3, (p0 + 2) % 3) if above_b > 0.0 else ((p0 + 2) % 3, (p0 + 1) % 3)
    q1, q2 = ((q0 + 1) % 3, (q0 + 2) % 3) if above_a > 0.0 else ((q0 + 2) % 3, (q0 + 1) % 3)
    p, r, s = corner(a, p0), corner(a, p1), corner(a, p2)
    q, u, v = corner(b, q0), corner(b, q1), corner(b, q2)
    sign = above_a * above_b
    if sign * orientation(p, r, q, u) > 0.0 or sign * orientation(p, s, q, v) < 0.0:
        return APART, NOWHERE, NOWHERE, 0, 0
    if sign * orientation(p, s, q, u) >= 0.0:
        first, begins = cut(b, hb, q0, q1), EDGES_OF_B + edge_between(q0, q1)
    else:
        first, begins = cut(a, ha, p0, p2), edge_between(p0, p2)
    if sign * orientation(p, r, q, v) >= 0.0:
        last, ends = cut(a, ha, p0, p1), edge_between(p0, p1)
    else:
        last, ends = cut(b, hb, q0, q2), EDGES_OF_B + edge_between(q0, q2)
    return CROSSING, first, last, begins, ends
