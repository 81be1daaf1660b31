"""How deep two overlapping convex cores are in each other: a polytope inside A - B grows until it reaches the closest face.

Source: van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001; the same, Collision
Detection in Interactive 3D Environments, 2003, section 4.3.8.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, cross, dot, neg, norm, perpendicular, scale, sub
from plumbline.engine.narrow.gjk import Simplex, corner, put_corner
from plumbline.engine.narrow.support import Solids

CORNERS = 160
"""Most corners of the polytope: a curved surface, of which each new corner quarters the error nearby, needs about 100."""
FACES = 400
"""Rows for faces; those of removed ones are used again."""
EXACT = 1e-12
"""Share of the size [1] by which a corner beyond a face no longer counts."""
PLANE_WIDTH = 1e-14
"""Share of the size [1] within which a corner lies in the plane of a face: such faces merge, else some without area arise."""
SLIM = 1e-10
"""Share of the size [1] below which a direction has no extent."""


@kernel
def put_face(work: Floats, key: Ints, row: int, i: int, j: int, k: int) -> None:
    """Write a face with its outward normal and its distance from the origin; one without an area is never the closest."""
    p, q, r = corner(work, i), corner(work, j), corner(work, k)
    one, two = sub(q, p), sub(r, p)
    n = cross(one, two)
    length = norm(n)
    key[row, 0], key[row, 1], key[row, 2], key[row, 3] = i, j, k, 1
    if length <= 1e-12 * norm(one) * norm(two) or length < 1e-290:
        store3(work, row, 0, (0.0, 0.0, 0.0))
        work[row, 3] = math.inf
        return
    n = scale(1.0 / length, n)
    store3(work, row, 0, n)
    work[row, 3] = (dot(n, p) + dot(n, q) + dot(n, r)) / 3.0


@kernel
def tetrahedron(t: Solids, a: int, b: int, d: Vec, size: float, work: Floats, count: int) -> tuple[int, Vec]:
    """Add corners to the simplex until it has a volume.

    Returns: the number of corners, below 4 where A - B is flat, and then its normal.
    """
    flat = (0.0, 0.0, 1.0)
    if count == 1:
        for k in range(6):
            sign = 1.0 if k < 3 else -1.0
            n = (sign if k % 3 == 0 else 0.0, sign if k % 3 == 1 else 0.0, sign if k % 3 == 2 else 0.0)
            if count == 1 and norm(sub(put_corner(t, a, b, d, n, work, 1), corner(work, 0))) > SLIM * size:
                count = 2
        if count == 1:
            return 1, flat
    if count == 2:
        e = sub(corner(work, 1), corner(work, 0))
        e = scale(1.0 / norm(e), e)
        u = perpendicular(e)
        v = cross(e, u)
        for k in range(6):
            c, s = cos_sin(k * math.pi / 3.0)
            n = axpy(c, u, scale(s, v))
            if count == 2:
                w = put_corner(t, a, b, d, n, work, 2)
                if norm(cross(e, sub(w, corner(work, 0)))) > SLIM * size:
                    count = 3
        if count == 2:
            return 2, u
    if count == 3:
        n = cross(sub(corner(work, 1), corner(work, 0)), sub(corner(work, 2), corner(work, 0)))
        length = norm(n)
        if length <= SLIM * SLIM * size * size:
            return 2, perpendicular(scale(1.0 / size, sub(corner(work, 1), corner(work, 0))))
        n = scale(1.0 / length, n)
        for k in range(2):
            way = n if k == 0 else neg(n)
            if count == 3:
                w = put_corner(t, a, b, d, way, work, 3)
                if dot(way, sub(w, corner(work, 0))) > SLIM * size:
                    count = 4
        if count == 3:
            return 3, n
    return 4, flat


@kernel
def witnesses(work: Floats, key: Ints, row: int) -> tuple[Vec, Vec]:
    """The points of A and of B that make the origin's projection on a face."""
    n = load3(work, row, 0)
    p, q, r = corner(work, key[row, 0]), corner(work, key[row, 1]), corner(work, key[row, 2])
    u, v, w = max(dot(n, cross(q, r)), 0.0), max(dot(n, cross(r, p)), 0.0), max(dot(n, cross(p, q)), 0.0)
    total = max(u + v + w, 1e-300)
    pa, pb = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for c in range(3):
        share = (u if c == 0 else (v if c == 1 else w)) / total
        pa = axpy(share, load3(work, key[row, c], 3), pa)
        pb = axpy(share, load3(work, key[row, c], 6), pb)
    return pa, pb


@kernel
def depth(t: Solids, a: int, b: int, d: Vec, size: float, count: int, simplex: Simplex) -> tuple[float, Vec, Vec, Vec]:
    """The least way [m] along which the overlapping cores of a and b part.

    Args: as `distance`; count: corners of the simplex that holds the origin.
    Returns: the depth, the normal from A to B, and the deepest points of A and of B, from the centre of A.
    """
    work, key = simplex
    count, flat = tetrahedron(t, a, b, d, size, work, count)
    if count < 4:
        flat = scale(1.0 / norm(flat), flat)
        n = flat if dot(flat, d) >= 0.0 else neg(flat)
        return 0.0, n, load3(work, 0, 3), load3(work, 0, 6)
    o = corner(work, 0)
    e1, e2, e3 = sub(corner(work, 1), o), sub(corner(work, 2), o), sub(corner(work, 3), o)
    i, j = (1, 2) if dot(cross(e1, e2), e3) < 0.0 else (2, 1)
    put_face(work, key, CORNERS, 0, i, j)
    put_face(work, key, CORNERS + 1, 0, j, 3)
    put_face(work, key, CORNERS + 2, 0, 3, i)
    put_face(work, key, CORNERS + 3, i, 3, j)
    corners, top, best, normal = 4, CORNERS + 4, math.inf, (0.0, 0.0, 1.0)
    pa, pb = load3(work, 0, 3), load3(work, 0, 6)
    while corners < CORNERS:
        nearest, least = -1, math.inf
        for f in range(CORNERS, top):
            if key[f, 3] == 1 and work[f, 3] < least:
                nearest, least = f, work[f, 3]
        if nearest < 0:
            break
        n = load3(work, nearest, 0)
        w = put_corner(t, a, b, d, n, work, corners)
        reach = dot(n, w)
        if reach < best:
            best, normal = reach, n
            pa, pb = witnesses(work, key, nearest)
        if reach - least <= EXACT * size:
            break
        horizon = 0
        for f in range(CORNERS, top):
            if key[f, 3] == 1 and dot(load3(work, f, 0), w) - work[f, 3] >= -PLANE_WIDTH * size:
                key[f, 3] = 0
                for c in range(3):
                    horizon = toggle_edge(key, horizon, key[f, c], key[f, (c + 1) % 3])
        row = CORNERS
        for e in range(horizon):
            while row < top and key[row, 3] == 1:
                row += 1
            if row >= CORNERS + FACES:
                return best, normal, pa, pb
            top = max(top, row + 1)
            put_face(work, key, row, key[e, 4], key[e, 5], corners)
        corners += 1
    return best, normal, pa, pb


@kernel
def toggle_edge(key: Ints, edges: int, i: int, j: int) -> int:
    """Add the edge i -> j to the horizon, or take j -> i off it. Returns: the number of its edges."""
    for e in range(edges):
        if key[e, 4] == j and key[e, 5] == i:
            key[e, 4], key[e, 5] = key[edges - 1, 4], key[edges - 1, 5]
            return edges - 1
    key[edges, 4], key[edges, 5] = i, j
    return edges + 1
