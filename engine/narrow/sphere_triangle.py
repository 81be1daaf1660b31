"""A sphere against the outer side of a triangle, by the point of the triangle that is closest to the centre.

Source: Ericson, Real-Time Collision Detection, section 5.1.5 (closest point on a triangle to a point, by Voronoi regions).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec, load3, load9
from plumbline.engine.maths.vec import mat_vec, neg, norm, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.point import Points, put_nearest
from plumbline.engine.narrow.support import Solids
from plumbline.engine.narrow.triangle import BACK, BESIDE, ON_EDGE, leans_over

TOUCHING = 1e-9
"""Share of the size [1] of a distance whose direction rounding spoils: the triangle's own normal is taken there."""


@kernel
def closest_on_triangle(vertex: Floats, first: int, x: float, y: float) -> tuple[float, float, float]:
    """The point of a triangle closest to (x, y), in its own plane.

    Args: vertex: from row `first` on the three corners, counter-clockwise about z, in the triangle's frame.
    Returns: the point, and how far [m] (x, y) lies beyond one of the edges, 0 within the triangle.
    """
    beyond, most, qx, qy = 0.0, math.inf, x, y
    for k in range(3):
        ax, ay = vertex[first + k, 0], vertex[first + k, 1]
        ex, ey = vertex[first + (k + 1) % 3, 0] - ax, vertex[first + (k + 1) % 3, 1] - ay
        px, py = x - ax, y - ay
        across, square = ey * px - ex * py, ex * ex + ey * ey
        if across <= 0.0:
            continue
        beyond = max(beyond, across / math.sqrt(square))
        share = min(max((ex * px + ey * py) / square, 0.0), 1.0)
        dx, dy = px - share * ex, py - share * ey
        if dx * dx + dy * dy < most:
            most, qx, qy = dx * dx + dy * dy, ax + share * ex, ay + share * ey
    return qx, qy, beyond


@kernel
def sphere_triangle(t: Solids, a: int, b: int, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Write the contact point of sphere A and triangle B. Returns: the number of points, and the normal from A to B.

    Over an edge that does not stick out the triangle's own normal alone is met, and that not beside it.
    """
    m, pa, pb = load9(t.pose, b, 3), load3(t.pose, a, 0), load3(t.pose, b, 0)
    radius, n = t.shape[a, at.SIZE], (-m[2], -m[5], -m[8])
    c = tmat_vec(m, sub(pa, pb))
    if c[2] < -radius:
        return 0, n
    qx, qy, beyond = closest_on_triangle(t.vertex, t.polyhedron[b, at.FIRST_VERTEX], c[0], c[1])
    way = (c[0] - qx, c[1] - qy, c[2])
    apart = norm(way)
    if apart - radius > margin or way[2] < -BACK * apart:
        return 0, n
    if beyond > 0.0 and apart > TOUCHING * (t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]):
        out_of_it = mat_vec(m, scale(1.0 / apart, way))
        if not leans_over(t, b, mat_vec(m, (qx, qy, 0.0)), out_of_it, t.polyhedron[b, at.INNER]):
            n = neg(out_of_it)
        elif way[2] < BESIDE * apart or beyond > ON_EDGE * t.shape[b, at.BALL_RADIUS]:
            return 0, n
    return put_nearest(out, row, pa, radius, n, apart - radius, margin, 1)
