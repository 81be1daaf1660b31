"""Where the points of a manifold are as its bodies move: arms, separations, and places about the centre."""

import math

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints, Vec, add, axpy, dot, load3, load4, mat_vec, neg, quat_mat, scale, store3, sub
from engine.memory.arena import (
    ARM_A,
    ARM_B,
    BODY_A,
    BODY_B,
    CENTRE_A,
    CENTRE_B,
    ELLIPSOID,
    LEADS,
    NORMAL,
    POINT_SHARE,
    POINTS,
    RIM_AXIS_A,
    RIM_AXIS_B,
    RIMS,
    ROUND_A,
    ROUND_B,
    SEPARATION,
    SHAPE_A,
    SHAPE_B,
    SPOT_A,
    SPOT_B,
    SPREAD,
    TANGENTS,
    TYPE,
    P,
    Q,
)
from engine.memory.tables import Contacts, Shapes
from engine.respond.rolling_ellipsoids import ON_ELLIPSOID, farthest
from engine.respond.rolling_rims import lowest_of

__all__ = ["refresh", "spread"]


@kernel
def spread(m: int, way: Vec, manifold: Floats, key: Ints, point: Floats) -> None:
    """The centre of a manifold, amid its points and in the tangent plane of the deepest, and the points' places about it.

    The deepest corner is the one furthest along the normal where the corners are those of A, least far where they are B's.

    Args: way [m] from A to B, in W.
    """
    n, t1, t2 = load3(manifold, m, NORMAL), load3(manifold, m, TANGENTS), load3(manifold, m, TANGENTS + 3)
    first, points = 4 * m, key[m, POINTS]
    way_in = 1.0 - 2.0 * key[m, LEADS]
    total, deepest = (0.0, 0.0, 0.0), -math.inf
    for i in range(first, first + points):
        arm = load3(point, i, ARM_A)
        total = add(total, arm)
        deepest = max(deepest, way_in * dot(n, arm))
    middle = scale(manifold[m, POINT_SHARE], total)
    centre = axpy(way_in * deepest - dot(n, middle), n, middle)
    store3(manifold, m, CENTRE_A, centre)
    store3(manifold, m, CENTRE_B, sub(centre, way))
    for i in range(first, first + points):
        d = sub(load3(point, i, ARM_A), centre)
        point[i, SPREAD], point[i, SPREAD + 1] = dot(t1, d), dot(t2, d)


@kernel
def refresh(state: Floats, shapes: Shapes, contacts: Contacts, end: int, first: int = 0) -> None:
    """Arms and separations of the points of the manifolds first..end - 1 at the present poses.

    A point goes with the corner or the round surface that makes it, while the other body slides under it; on the rim of a
    tilted cylinder it rolls on, or a disc on its edge would lose its tilt, in proportion to the time step; on an ellipsoid it
    stays the farthest along the normal. Both arms lead to one place, which keeps angular momentum.
    """
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for m in range(first, end):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        pa, pb = load3(state, a, P), load3(state, b, P)
        ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
        way = sub(pb, pa)
        low_a, low_b = n, n
        if manifold[m, RIMS] == 1.0:
            low_a = lowest_of(mat_vec(ra_wb, load3(manifold, m, RIM_AXIS_A)), n)
            low_b = lowest_of(mat_vec(rb_wb, load3(manifold, m, RIM_AXIS_B)), scale(-1.0, n))
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            ra, rb = mat_vec(ra_wb, load3(point, i, SPOT_A)), mat_vec(rb_wb, load3(point, i, SPOT_B))
            round_a, round_b = point[i, ROUND_A], point[i, ROUND_B]
            ra = axpy(round_a, n, ra) if round_a >= 0.0 else axpy(-round_a, low_a, ra)
            rb = axpy(-round_b, n, rb) if round_b >= 0.0 else axpy(-round_b, low_b, rb)
            if manifold[m, RIMS] == ON_ELLIPSOID:
                if shapes.kind[key[m, SHAPE_A], TYPE] == ELLIPSOID:
                    ra = farthest(shapes.shape, key[m, SHAPE_A], ra_wb, n)
                if shapes.kind[key[m, SHAPE_B], TYPE] == ELLIPSOID:
                    rb = farthest(shapes.shape, key[m, SHAPE_B], rb_wb, neg(n))
            gap = dot(n, add(way, sub(rb, ra)))
            point[i, SEPARATION] = gap
            if key[m, LEADS] == 0:
                ra = axpy(0.5 * gap, n, ra)
                rb = sub(ra, way)
            else:
                rb = axpy(-0.5 * gap, n, rb)
                ra = add(rb, way)
            store3(point, i, ARM_A, ra)
            store3(point, i, ARM_B, rb)
        spread(m, way, manifold, key, point)
