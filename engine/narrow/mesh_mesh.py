"""Contacts of two triangles of two meshes, each the skin of a solid: what of one is behind the other, or how near it comes.

Where they cross, the ends of their segment tell which features meet: both on edges of A, and corners of A are behind B's face;
both on edges of B, the other way round; one on an edge of each, and the two edges have passed each other. Of these ways out the
shortest is the normal. Where they do not cross, it is the direction of their closest points, unless that leads into a solid,
which another pair answers, or over an edge that does not stick out, where a face's own normal is left.

Source: Moller, A Fast Triangle-Triangle Intersection Test, 1997; Gregorius, The Separating Axis Test between Convex Polyhedra,
GDC 2013 (faces against edges, clipping); Bender, Erleben, Trinkle, Interactive Simulation of Rigid Body Dynamics in Computer
Graphics, 2014, section 4 (one-sided triangles).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Mat, Vec, load3, load9
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, neg, norm, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.clip_features import clip_features
from plumbline.engine.narrow.features import write_feature
from plumbline.engine.narrow.gjk import Simplex, closest_points, distance
from plumbline.engine.narrow.point import CORNERS_OF_B, Points, put_point
from plumbline.engine.narrow.support import Solids
from plumbline.engine.narrow.triangle import leans_over
from plumbline.engine.narrow.triangle_triangle import CROSSING, EDGES_OF_B, corner, triangle_triangle

HANDICAP = 1e-3
"""Share of the smaller triangle's radius [1] by which another normal must beat that of a face."""
ALIGNED = 0.9999
"""Cosine above which two triangles that face each other lie flat on each other."""
SUNK = 0.1
"""Share of the margin [1] that a triangle may lie behind another, flat on it, and still be answered by that pair."""
INTO = 1e-3
"""Sine by which a normal may lean into a solid."""
TOUCHING = 1e-9
"""Share of the size [1] of a distance whose direction rounding spoils."""
DEEP = 8.0
"""How many times as long as the segment of two triangles a way out may be: a longer one is not out of this crossing."""
ALONG = 1e-3
"""Sine of the angle between two edges below which they have no common normal."""
ON_FACE = 1 << 14
"""Features of corners and crossings on a face count from here, those of two edges from twice as far."""


@kernel
def corners_of(t: Solids, s: int, centre: Vec) -> Mat:
    """The corners [m] of triangle s, by rows, along the axes of W, with its centre there."""
    m, first = load9(t.pose, s, 3), t.polyhedron[s, at.FIRST_VERTEX]
    x = add(centre, mat_vec(m, load3(t.vertex, first, 0)))
    y = add(centre, mat_vec(m, load3(t.vertex, first + 1, 0)))
    z = add(centre, mat_vec(m, load3(t.vertex, first + 2, 0)))
    return x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]


@kernel
def heights(corners: Mat, on: Vec, n: Vec) -> Vec:
    """How far [m] corners lie over the plane through a point with the unit normal n."""
    x, y, z = corner(corners, 0), corner(corners, 1), corner(corners, 2)
    return dot(n, sub(x, on)), dot(n, sub(y, on)), dot(n, sub(z, on))


@kernel
def on_face(t: Solids, face: int, other: int, n: Vec, margin: float, out: Points, row: int, marker: int) -> int:
    """Write what of another triangle lies over a triangle with the outward normal n, or behind it. Returns: points, up to 4."""
    write_feature(t, face, t.polyhedron[face, at.FIRST_FACE], n, out, 0)
    write_feature(t, other, t.polyhedron[other, at.FIRST_FACE], n, out, out.polygon.shape[0] // 3)
    return clip_features(3, 3, n, 0.0, margin, out, row, marker)


@kernel
def on_b(t: Solids, a: int, b: int, nb: Vec, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """The contact of A with the face of B."""
    return on_face(t, b, a, nb, margin, out, row, ON_FACE), neg(nb)


@kernel
def on_a(t: Solids, a: int, b: int, na: Vec, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """The contact of B with the face of A."""
    return on_face(t, a, b, na, margin, out, row, CORNERS_OF_B + ON_FACE), na


@kernel
def way_out(t: Solids, s: int, corners: Mat, centre: Vec, over: Vec, out: Vec) -> float:
    """How deep [m] the deepest corner of triangle s lies behind a plane; inf where it is no tip of its mesh.

    Args: corners: of s; centre: of s; over: heights of its corners; out: into the plane. The mesh goes on, deeper, where that
    leans over an edge at the corner that does not stick out, or through the back of s.
    """
    k = 0 if over[0] <= over[1] and over[0] <= over[2] else (1 if over[1] <= over[2] else 2)
    if leans_over(t, s, sub(corner(corners, k), centre), out, t.polyhedron[s, at.INNER]):
        return math.inf
    return -over[k]


@kernel
def passed_edges(a: Mat, b: Mat, i: int, j: int, na: Vec, nb: Vec) -> tuple[float, Vec, Vec]:
    """Edge i of A against edge j of B, which have passed each other.

    Returns: their gap [m], below zero, or -inf where they have no normal that leads out of both; the normal from A to B; the
    point midway between them.
    """
    x, y = corner(a, i), corner(b, j)
    ea, eb = sub(corner(a, i + 1), x), sub(corner(b, j + 1), y)
    n = cross(ea, eb)
    length = norm(n)
    if length <= ALONG * norm(ea) * norm(eb):
        return -math.inf, n, x
    n = scale((1.0 if dot(n, sub(na, nb)) > 0.0 else -1.0) / length, n)
    if dot(n, na) < -INTO or dot(n, nb) > INTO:
        return -math.inf, n, x
    way, across = sub(y, x), cross(ea, eb)
    s, r = dot(cross(way, eb), across) / (length * length), dot(cross(way, ea), across) / (length * length)
    return min(dot(n, way), 0.0), n, scale(0.5, add(axpy(s, ea, x), axpy(r, eb, y)))


@kernel
def mesh_contact(
    t: Solids, a: int, b: int, margin: float, sunk: float, simplex: Simplex, out: Points, row: int
) -> tuple[int, Vec]:  # fmt: skip
    """Write the contact points of triangles a and b of two meshes from row `row` on.

    Args: margin [m]: as far apart as they may be; sunk [m]: how deep one may lie behind the other, flat on it.
    Returns: the number of points, at most four, and the normal from a to b.
    """
    pa, pb = load3(t.pose, a, 0), load3(t.pose, b, 0)
    d = sub(pb, pa)
    na, nb = (t.pose[a, 5], t.pose[a, 8], t.pose[a, 11]), (t.pose[b, 5], t.pose[b, 8], t.pose[b, 11])
    one, two = corners_of(t, a, (0.0, 0.0, 0.0)), corners_of(t, b, d)
    over_b, over_a = heights(one, d, nb), heights(two, (0.0, 0.0, 0.0), na)
    if min(over_b) > margin or min(over_a) > margin:
        return 0, na
    if dot(na, nb) < -ALIGNED and min(over_b) > -sunk:
        # The larger one has the steadier normal, the same for all that lie on it.
        if t.shape[a, at.BALL_RADIUS] > t.shape[b, at.BALL_RADIUS]:
            return on_a(t, a, b, na, margin, out, row)
        return on_b(t, a, b, nb, margin, out, row)
    if max(over_b) < 0.0 or max(over_a) < 0.0:
        return 0, na
    met, first, last, begins, ends = triangle_triangle(one, two)
    size = t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]
    slack = HANDICAP * min(t.shape[a, at.BALL_RADIUS], t.shape[b, at.BALL_RADIUS])
    gap, v, count = 0.0, na, 0
    if met != CROSSING:
        gap, v, count = distance(t, a, b, d, size, margin, simplex.work)
    if gap <= TOUCHING * size:
        behind_b = way_out(t, a, one, (0.0, 0.0, 0.0), over_b, neg(nb))
        behind_a = way_out(t, b, two, d, over_a, neg(na))
        most = DEEP * norm(sub(last, first)) + sunk if met == CROSSING else sunk
        if met == CROSSING and (begins < EDGES_OF_B) != (ends < EDGES_OF_B):
            i, j = (begins, ends - EDGES_OF_B) if begins < EDGES_OF_B else (ends, begins - EDGES_OF_B)
            if t.polyhedron[a, at.INNER] & (1 << i) == 0 and t.polyhedron[b, at.INNER] & (1 << j) == 0:
                gap, n, middle = passed_edges(one, two, i, j, na, nb)
                if -gap < min(behind_a, behind_b, most):
                    put_point(out, row, add(pa, middle), gap, 2 * ON_FACE + 3 * i + j)
                    return 1, n
        if min(behind_a, behind_b) > most:
            return 0, na
        if behind_b <= behind_a:
            return on_b(t, a, b, nb, margin, out, row)
        return on_a(t, a, b, na, margin, out, row)
    if gap > margin:
        return 0, na
    qa, qb = closest_points(simplex.work, count)
    n = scale(-1.0 / norm(v), v)
    if dot(n, na) < -INTO or dot(n, nb) > INTO:
        return 0, n
    over_edge_a = leans_over(t, a, qa, n, t.polyhedron[a, at.INNER])
    over_edge_b = leans_over(t, b, sub(qb, d), neg(n), t.polyhedron[b, at.INNER])
    # Where the other triangle is not in front of that face, another triangle at the same edge or corner has the contact.
    if (over_edge_a and (over_edge_b or min(over_a) < -sunk)) or (over_edge_b and min(over_b) < -sunk):
        return 0, n
    if over_edge_b or (not over_edge_a and gap - min(over_b) <= slack):
        return on_b(t, a, b, nb, margin, out, row)
    if over_edge_a or gap - min(over_a) <= slack:
        return on_a(t, a, b, na, margin, out, row)
    put_point(out, row, add(pa, scale(0.5, add(qa, qb))), gap, 2 * ON_FACE + 16)
    return 1, n


@kernel
def mesh_plane(t: Solids, plane: int, s: int, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Plane A against triangle B of a mesh: its corners, unless it looks away from the plane.

    A corner nearer to the plane than its neighbours has a triangle that looks at it.
    """
    up = (t.pose[plane, 5], t.pose[plane, 8], t.pose[plane, 11])
    if dot(up, (t.pose[s, 5], t.pose[s, 8], t.pose[s, 11])) > -INTO * INTO:
        return 0, up
    pa, corners, points = load3(t.pose, plane, 0), corners_of(t, s, load3(t.pose, s, 0)), 0
    for k in range(3):
        x = corner(corners, k)
        gap = dot(up, sub(x, pa))
        if gap <= margin:
            put_point(out, row + points, axpy(-0.5 * gap, up, x), gap, CORNERS_OF_B + k)
            points += 1
    return points, up
