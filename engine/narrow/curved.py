"""The normal between an ellipsoid and another core to rounding: Newton's method on the sphere of directions.

The signed distance of two convex bodies is the largest of their separations s(n) = n . (d + p_B(-n) - p_A(n)) over all unit
normals n (in penetration: the nearest such maximum). With w(n) the way between the farthest points, the tangential part of w is
the gradient of s, and -(H_A + H_B + s) its second derivative, H the radii of curvature of a surface by its normal:

    H = (M - M n n^T M / h^2) / h,   h = sqrt(n . M n),   M = R D^2 R^T,   D the semi-axes.

GJK and EPA end where the distance is known to rounding, which leaves half of the digits of the normal; two steps give the rest.

Source: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds, 2008, chapter 6 (Newton's method on a sphere);
Schneider, Convex Bodies: The Brunn-Minkowski Theory, 2014, section 2.5 (curvature and the support function).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec, load3, load9
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, neg, norm, perpendicular, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.support import Solids, core_support

ROUNDS = 8
ROUGH = 1e-15
"""Rounding of a separation against the size of both shapes [1]: a step that loses more has left the maximum."""


@kernel
def radii_along(t: Solids, s: int, n: Vec, e: Vec) -> Vec:
    """H e for a tangent e: how the farthest point of shape s moves as its normal n turns along e [m]; 0 but for ellipsoids."""
    if t.shape_kind[s, at.TYPE] != at.ELLIPSOID:
        return 0.0, 0.0, 0.0
    m, size = load9(t.pose, s, 3), load3(t.shape, s, at.SIZE)
    u, v = tmat_vec(m, n), tmat_vec(m, e)
    square = (size[0] * size[0], size[1] * size[1], size[2] * size[2])
    mu = (square[0] * u[0], square[1] * u[1], square[2] * u[2])
    mv = (square[0] * v[0], square[1] * v[1], square[2] * v[2])
    h2 = dot(u, mu)
    return mat_vec(m, scale(1.0 / math.sqrt(h2), axpy(-dot(u, mv) / h2, mu, mv)))


@kernel
def way_between(t: Solids, a: int, b: int, d: Vec, n: Vec) -> Vec:
    """From the point of A farthest along n to the point of B farthest against it [m]."""
    return sub(add(d, core_support(t, b, neg(n))), core_support(t, a, n))


@kernel
def newton_step(t: Solids, a: int, b: int, n: Vec, w: Vec) -> Vec:
    """The next unit normal; n itself where the separation does not curve down, so that there is no maximum near."""
    e1 = perpendicular(n)
    e2 = cross(n, e1)
    r1 = add(radii_along(t, a, n, e1), radii_along(t, b, neg(n), e1))
    r2 = add(radii_along(t, a, n, e2), radii_along(t, b, neg(n), e2))
    s = dot(n, w)
    k11, k12, k22 = dot(e1, r1) + s, 0.5 * (dot(e1, r2) + dot(e2, r1)), dot(e2, r2) + s
    determinant = k11 * k22 - k12 * k12
    if not (k11 > 0.0 and determinant > 0.0):
        return n
    g1, g2 = dot(e1, w), dot(e2, w)
    turned = axpy((k22 * g1 - k12 * g2) / determinant, e1, axpy((k11 * g2 - k12 * g1) / determinant, e2, n))
    return scale(1.0 / norm(turned), turned)


@kernel
def sharpen(t: Solids, a: int, b: int, d: Vec, size: float, parted: tuple[float, Vec, Vec, Vec]) -> tuple[float, Vec, Vec, Vec]:
    """What `part_cores` returns, the normal taken to rounding where A or B is an ellipsoid. Args: parted: the same before.

    Edges of the other shape are kinks of the separation, where no step gains: what GJK said of them stays.
    """
    kind_a, kind_b = t.shape_kind[a, at.TYPE], t.shape_kind[b, at.TYPE]
    if kind_a != at.ELLIPSOID and kind_b != at.ELLIPSOID:
        return parted
    gap, n, qa, qb = parted
    w = way_between(t, a, b, d, n)
    for _ in range(ROUNDS):
        s = dot(n, w)
        across = norm(axpy(-s, n, w))
        ahead = newton_step(t, a, b, n, w)
        way = way_between(t, a, b, d, ahead)
        reached = dot(ahead, way)
        if reached < s - ROUGH * size or norm(axpy(-reached, ahead, way)) >= 0.5 * across:
            break
        n, w = ahead, way
    gap = dot(n, w)
    if kind_a == at.ELLIPSOID:
        qa = core_support(t, a, n)
        return gap, n, qa, axpy(gap, n, qa)
    qb = add(d, core_support(t, b, neg(n)))
    return gap, n, axpy(-gap, n, qb), qb
