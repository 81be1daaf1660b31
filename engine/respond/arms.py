"""Where the points of a manifold are as its bodies move: arms, separations, and places about the centre."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, store3
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, neg, quat_mat, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts, Shapes
from plumbline.engine.respond.rolling import ON_ELLIPSOID, farthest, lowest_of


@kernel
def spread(m: int, way: Vec, manifold: Floats, key: Ints, point: Floats) -> None:
    """The centre of a manifold, amid its points and in the tangent plane of the deepest, and the points' places about it.

    The deepest corner is the one furthest along the normal where the corners are those of A, least far where they are B's.

    Args: way [m] from A to B, in W.
    """
    n, t1, t2 = load3(manifold, m, at.NORMAL), load3(manifold, m, at.TANGENTS), load3(manifold, m, at.TANGENTS + 3)
    first, points = 4 * m, key[m, at.POINTS]
    way_in = 1.0 - 2.0 * key[m, at.LEADS]
    total, deepest = (0.0, 0.0, 0.0), -math.inf
    for i in range(first, first + points):
        arm = load3(point, i, at.ARM_A)
        total = add(total, arm)
        deepest = max(deepest, way_in * dot(n, arm))
    middle = scale(manifold[m, at.POINT_SHARE], total)
    centre = axpy(way_in * deepest - dot(n, middle), n, middle)
    store3(manifold, m, at.CENTRE_A, centre)
    store3(manifold, m, at.CENTRE_B, sub(centre, way))
    for i in range(first, first + points):
        d = sub(load3(point, i, at.ARM_A), centre)
        point[i, at.SPREAD], point[i, at.SPREAD + 1] = dot(t1, d), dot(t2, d)


@kernel
def refresh(state: Floats, shapes: Shapes, contacts: Contacts) -> None:
    """Arms and separations of the points of the manifolds at the present poses.

    A point goes with the corner or the round surface that makes it, while the other body slides under it; on the rim of a
    tilted cylinder it rolls on, or a disc on its edge would lose its tilt, in proportion to the time step; on an ellipsoid it
    stays the farthest along the normal. Both arms lead to one place, which keeps angular momentum.
    """
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    for rank in range(len(contacts.order)):
        m = contacts.order[rank, 0]
        a, b = key[m, at.BODY_A], key[m, at.BODY_B]
        n = load3(manifold, m, at.NORMAL)
        pa, pb = load3(state, a, at.P), load3(state, b, at.P)
        ra_wb, rb_wb = quat_mat(load4(state, a, at.Q)), quat_mat(load4(state, b, at.Q))
        way = sub(pb, pa)
        low_a, low_b = n, n
        if manifold[m, at.RIMS] == 1.0:
            low_a = lowest_of(mat_vec(ra_wb, load3(manifold, m, at.RIM_AXIS_A)), n)
            low_b = lowest_of(mat_vec(rb_wb, load3(manifold, m, at.RIM_AXIS_B)), scale(-1.0, n))
        for k in range(key[m, at.POINTS]):
            i = 4 * m + k
            ra, rb = mat_vec(ra_wb, load3(point, i, at.SPOT_A)), mat_vec(rb_wb, load3(point, i, at.SPOT_B))
            round_a, round_b = point[i, at.ROUND_A], point[i, at.ROUND_B]
            ra = axpy(round_a, n, ra) if round_a >= 0.0 else axpy(-round_a, low_a, ra)
            rb = axpy(-round_b, n, rb) if round_b >= 0.0 else axpy(-round_b, low_b, rb)
            if manifold[m, at.RIMS] == ON_ELLIPSOID:
                if shapes.kind[key[m, at.SHAPE_A], at.TYPE] == at.ELLIPSOID:
                    ra = farthest(shapes.shape, key[m, at.SHAPE_A], ra_wb, n)
                if shapes.kind[key[m, at.SHAPE_B], at.TYPE] == at.ELLIPSOID:
                    rb = farthest(shapes.shape, key[m, at.SHAPE_B], rb_wb, neg(n))
            gap = dot(n, add(way, sub(rb, ra)))
            point[i, at.SEPARATION] = gap
            if key[m, at.LEADS] == 0:
                ra = axpy(0.5 * gap, n, ra)
                rb = sub(ra, way)
            else:
                rb = axpy(-0.5 * gap, n, rb)
                ra = add(rb, way)
            store3(point, i, at.ARM_A, ra)
            store3(point, i, at.ARM_B, rb)
        spread(m, way, manifold, key, point)
