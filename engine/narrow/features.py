"""The flat or straight part of a shape's surface that faces a direction: a face, a cap, a line or a point.

Source: Gregorius, The Separating Axis Test between Convex Polyhedra, GDC 2013 (reference and incident features).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import cos_sin
from plumbline.engine.maths.rows import Vec, load3, load9, store3
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.point import Points
from plumbline.engine.narrow.support import Solids, core_support

RIM = 16
"""Corners of the polygon that stands for a cap: its sides lie within 2 % of the radius of the rim."""
UPRIGHT = 1e-3
"""Sine of the tilt below which a cap starts its polygon at the same point of the rim, whichever is lowest."""
TIE = 1e-9
"""Share of the reach [1] within which a corner counts as one of the farthest."""


@kernel
def facing(t: Solids, s: int, n: Vec) -> tuple[int, Vec, float]:
    """The face through the farthest corner along n that looks most along n.

    Returns: its row, -1 for a cap or where there is no face; its outward normal in W; the cosine between it and n, -2 if none.
    """
    kind = t.shape_kind[s, at.TYPE]
    if kind in (at.SPHERE, at.CAPSULE, at.ELLIPSOID):
        return -1, n, -2.0
    m = load9(t.pose, s, 3)
    u = tmat_vec(m, n)
    if kind == at.CYLINDER:
        sign = math.copysign(1.0, u[2])
        return -1, (sign * m[2], sign * m[5], sign * m[8]), abs(u[2])
    most, spread, first = -math.inf, 0.0, t.polyhedron[s, at.FIRST_VERTEX]
    for k in range(first, first + t.polyhedron[s, at.VERTICES]):
        reach = dot(u, load3(t.vertex, k, 0))
        most, spread = max(most, reach), max(spread, abs(reach))
    best, cosine = -1, -2.0
    for f in range(t.polyhedron[s, at.FIRST_FACE], t.polyhedron[s, at.FIRST_FACE] + t.polyhedron[s, at.FACES]):
        c = dot(u, load3(t.face, f, 0))
        if c > cosine + 1e-12:
            for k in range(t.span[f, 0], t.span[f, 0] + t.span[f, 1]):
                if dot(u, load3(t.vertex, t.loop[k, 0], 0)) >= most - TIE * spread:
                    best, cosine = f, c
                    break
    return best, mat_vec(m, load3(t.face, best, 0)), cosine


@kernel
def is_line(t: Solids, s: int, n: Vec) -> bool:
    """Whether what faces n is a straight line on a round side."""
    kind = t.shape_kind[s, at.TYPE]
    axis = (t.pose[s, 5], t.pose[s, 8], t.pose[s, 11])
    return (kind in (at.CAPSULE, at.CYLINDER)) and abs(dot(axis, n)) < UPRIGHT


@kernel
def write_feature(t: Solids, s: int, face: int, n: Vec, out: Points, row: int) -> int:
    """Write the corners, in W, of what faces n into the polygon, counter-clockwise seen from outside. Returns: their number.

    Args: face: row of a polyhedron's face, as `facing` gives it; row: the first of `out`.
    """
    polygon, key = out.polygon, out.polygon_key
    kind = t.shape_kind[s, at.TYPE]
    m, p = load9(t.pose, s, 3), load3(t.pose, s, 0)
    if kind in (at.SPHERE, at.ELLIPSOID):
        store3(polygon, row, 0, add(p, core_support(t, s, n)))
        key[row, 0] = 0
        return 1
    if kind != at.CAPSULE and kind != at.CYLINDER:
        first, corners = t.span[face, 0], t.span[face, 1]
        for k in range(corners):
            v = t.loop[first + k, 0]
            store3(polygon, row + k, 0, add(p, mat_vec(m, load3(t.vertex, v, 0))))
            key[row + k, 0] = v - t.polyhedron[s, at.FIRST_VERTEX]
        return int(corners)
    u = tmat_vec(m, n)
    across = math.sqrt(u[0] * u[0] + u[1] * u[1])
    half = t.shape[s, at.SIZE + 1]
    radius = t.shape[s, at.SIZE] if kind == at.CYLINDER else 0.0
    x, y = (u[0] / across, u[1] / across) if across > UPRIGHT else (1.0, 0.0)
    if kind == at.CAPSULE or abs(u[2]) < math.sqrt(0.5):
        for k in range(2):
            store3(polygon, row + k, 0, add(p, mat_vec(m, (radius * x, radius * y, half if k == 0 else -half))))
            key[row + k, 0] = k
        return 2
    side = math.copysign(1.0, u[2])
    for k in range(RIM):
        angle = side * k * 2.0 * math.pi / RIM
        c, sn = cos_sin(angle)
        rim = axpy(radius, (c * x - sn * y, sn * x + c * y, 0.0), (0.0, 0.0, side * half))
        store3(polygon, row + k, 0, add(p, mat_vec(m, rim)))
        key[row + k, 0] = k
    return RIM
