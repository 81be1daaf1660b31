"""The signed distance of two shapes of any kind at their present poses, by the same GJK and EPA as the contacts.

Source: van den Bergen, Collision Detection in Interactive 3D Environments, 2003, sections 4.3.4 and 4.3.8.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec, load3
from plumbline.engine.maths.vec import add, axpy, dot, neg, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.convex import part_cores
from plumbline.engine.narrow.gjk import Simplex
from plumbline.engine.narrow.support import Solids, core_radius, core_support


@kernel
def above_plane(t: Solids, plane: int, s: int) -> tuple[float, Vec, Vec]:
    """The gap [m] of shape s over a plane, the plane's normal, and the lowest point of s, in W."""
    up = (t.pose[plane, 5], t.pose[plane, 8], t.pose[plane, 11])
    lowest = axpy(-core_radius(t, s), up, add(load3(t.pose, s, 0), core_support(t, s, neg(up))))
    return dot(up, sub(lowest, load3(t.pose, plane, 0))), up, lowest


@kernel
def separation(t: Solids, a: int, b: int, simplex: Simplex) -> tuple[float, Vec, Vec, Vec]:
    """The gap [m] of shapes a and b, negative in penetration, the normal from A to B, and their closest points in W."""
    if t.shape_kind[a, at.TYPE] == at.PLANE:
        gap, up, spot = above_plane(t, a, b)
        return gap, up, axpy(-gap, up, spot), spot
    if t.shape_kind[b, at.TYPE] == at.PLANE:
        gap, up, spot = above_plane(t, b, a)
        return gap, neg(up), spot, axpy(-gap, up, spot)
    pa, ra, rb = load3(t.pose, a, 0), core_radius(t, a), core_radius(t, b)
    size = t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]
    gap, n, qa, qb = part_cores(t, a, b, sub(load3(t.pose, b, 0), pa), size, math.inf, simplex)
    return gap - ra - rb, n, add(pa, axpy(ra, n, qa)), add(pa, axpy(-rb, n, qb))
