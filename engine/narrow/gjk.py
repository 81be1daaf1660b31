"""The distance of two convex cores: the point of their Minkowski difference A - B closest to the origin.

Source: Gilbert, Johnson, Keerthi, IEEE J. Robotics and Automation 4, 1988; van den Bergen, Collision Detection in Interactive
3D Environments, 2003, section 4.3; Ericson, Real-Time Collision Detection, sections 5.1.5, 5.1.6 and 9.5 (closest points of
sub-simplices).
"""

import math
from typing import Annotated, NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, neg, norm, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved
from plumbline.engine.narrow.support import Solids, core_support

MAX_ROUNDS = 128
CLOSE = 1e-14
"""Relative gap between upper and lower bound of the squared distance at which the search ends."""
SLIM = 1e-10
"""Height of a tetrahedron against its edges [1] below which it encloses nothing: less than what counts as touching."""
ROUGH = 1e-14
"""Relative rounding of a volume, with a margin: a smaller one has no sign, and so tells no side of a face."""
SHARE = 9
"""Column of a simplex row: the barycentric coordinate; before it stand the difference, the point of A and that of B."""


class Simplex(NamedTuple):
    """Scratch: corners of A - B, first those of the simplex, and the faces that EPA spans over them."""

    work: Annotated[Floats, at.SIMPLEX]
    key: Annotated[Ints, at.SIMPLEX_KEY]


simplex_of = carved(Simplex)


@kernel
def put_corner(t: Solids, a: int, b: int, d: Vec, n: Vec, work: Floats, row: int) -> Vec:
    """Write the corner of A - B farthest along n, with its points of A and B, both from the centre of A."""
    pa, pb = core_support(t, a, n), add(d, core_support(t, b, neg(n)))
    w = sub(pa, pb)
    store3(work, row, 0, w)
    store3(work, row, 3, pa)
    store3(work, row, 6, pb)
    return w


@kernel
def corner(work: Floats, row: int) -> Vec:
    """A corner of A - B."""
    return load3(work, row, 0)


@kernel
def on_segment(a: Vec, b: Vec) -> Vec:
    """Barycentric coordinates (a, b, 0) of the point of a segment closest to the origin."""
    e = sub(b, a)
    length2 = dot(e, e)
    s = min(max(-dot(a, e) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return 1.0 - s, s, 0.0


@kernel
def on_triangle(a: Vec, b: Vec, c: Vec) -> Vec:
    """Barycentric coordinates of the point of a triangle closest to the origin."""
    ab, ac = sub(b, a), sub(c, a)
    n = cross(ab, ac)
    area2 = dot(n, n)
    if area2 > 0.0:
        u, v, w = dot(n, cross(b, c)), dot(n, cross(c, a)), dot(n, cross(a, b))
        if u >= 0.0 and v >= 0.0 and w >= 0.0:
            total = u + v + w
            return u / total, v / total, w / total
    p, q, r = on_segment(a, b), on_segment(b, c), on_segment(c, a)
    x, y, z = axpy(p[0], a, scale(p[1], b)), axpy(q[0], b, scale(q[1], c)), axpy(r[0], c, scale(r[1], a))
    if dot(x, x) <= dot(y, y) and dot(x, x) <= dot(z, z):
        return p
    if dot(y, y) <= dot(z, z):
        return 0.0, q[0], q[1]
    return r[1], 0.0, r[0]


@kernel
def closest_of_simplex(work: Floats, count: int) -> bool:
    """Write the barycentric coordinates of the simplex's point closest to the origin. Returns: whether it holds the origin."""
    a = corner(work, 0)
    if count == 1:
        work[0, SHARE] = 1.0
        return False
    b = corner(work, 1)
    if count == 2:
        s = on_segment(a, b)
        work[0, SHARE], work[1, SHARE] = s[0], s[1]
        return False
    if count == 3:
        s = on_triangle(a, b, corner(work, 2))
        work[0, SHARE], work[1, SHARE], work[2, SHARE] = s[0], s[1], s[2]
        return False
    best, inside = math.inf, True
    for apex in range(4):
        i, j, k = (apex + 1) % 4, (apex + 2) % 4, (apex + 3) % 4
        p, q, r, top = corner(work, i), corner(work, j), corner(work, k), corner(work, apex)
        n = cross(sub(q, p), sub(r, p))
        here, there = -dot(p, n), dot(sub(top, p), n)
        sliver = ROUGH * norm(sub(q, p)) * norm(sub(r, p)) * (norm(sub(top, p)) + norm(p))
        if here * there > 0.0 and abs(there) > max(SLIM * norm(n) * norm(sub(top, p)), sliver) and abs(here) > sliver:
            continue
        inside = False
        s = on_triangle(p, q, r)
        x = axpy(s[0], p, axpy(s[1], q, scale(s[2], r)))
        if dot(x, x) < best:
            best = dot(x, x)
            work[i, SHARE], work[j, SHARE], work[k, SHARE], work[apex, SHARE] = s[0], s[1], s[2], 0.0
    return inside


@kernel
def closest_points(work: Floats, count: int) -> tuple[Vec, Vec]:
    """The points of A and of B that the shares of a simplex of so many corners tell, both from the centre of A."""
    qa, qb = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(count):
        qa, qb = axpy(work[k, SHARE], load3(work, k, 3), qa), axpy(work[k, SHARE], load3(work, k, 6), qb)
    return qa, qb


@kernel
def distance(t: Solids, a: int, b: int, d: Vec, size: float, most: float, work: Floats) -> tuple[float, Vec, int]:
    """The distance [m] of the cores of shapes a and b, whose centres lie d apart.

    Args: size [m] of both together; most [m]: the search ends as soon as the distance is known to be larger; work: rows for
    the simplex, whose shares give the closest points.
    Returns: the distance, 0 where they overlap; the vector from B to A; the number of corners of the simplex.
    """
    put_corner(t, a, b, d, d if dot(d, d) > 0.0 else (1.0, 0.0, 0.0), work, 0)
    work[0, SHARE] = 1.0
    count = 1
    v = corner(work, 0)
    touch = 1e-14 * size
    for _ in range(MAX_ROUNDS):
        length2 = dot(v, v)
        length = math.sqrt(length2)
        if length <= touch:
            return 0.0, v, count
        w = put_corner(t, a, b, d, neg(v), work, count)
        reach = dot(v, w)
        if reach > most * length:
            return length, v, count
        if length2 - reach <= CLOSE * length2:
            return length, v, count
        for k in range(count):
            if norm(sub(w, corner(work, k))) == 0.0:
                return length, v, count
        if closest_of_simplex(work, count + 1):
            return 0.0, v, count + 1
        new = (0.0, 0.0, 0.0)
        for k in range(count + 1):
            new = axpy(work[k, SHARE], corner(work, k), new)
        if dot(new, new) >= length2:
            closest_of_simplex(work, count)
            return length, v, count
        kept = 0
        for k in range(count + 1):
            if work[k, SHARE] > 0.0:
                for c in range(SHARE + 1):
                    work[kept, c] = work[k, c]
                kept += 1
        count, v = kept, new
    return norm(v), v, count
