"""Convex polygons in perspective: cut by the near plane, then filled row by row between their edges.

A pixel belongs to a polygon if its centre lies inside, or on a left or upper edge: of two polygons at one edge exactly one has
it. Corners are rounded to a fine grid of the screen, so that the corners of two triangles at one place are the same.

Source: Sutherland, Hodgman, Reentrant Polygon Clipping, 1974; Pineda, A Parallel Algorithm for Polygon Rasterization, 1988 (the
rule for edges).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.images.screen import Screen, flat_row, pixel_range, row_of
from plumbline.engine.maths.rows import Floats, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, dot, sub

GRID = float(2**20)
"""Steps of a pixel that corners are rounded to."""


@kernel
def clip_near(count: int, corner: Floats, near: float, kept: Floats) -> int:
    """Write the part z >= near of a polygon. Returns: how many corners it has.

    A cut edge is walked from its inner to its outer end, whichever polygon it belongs to, so that neighbours share the cut.
    """
    found = 0
    for k in range(count):
        a, b = load3(corner, k, 0), load3(corner, (k + 1) % count, 0)
        if a[2] >= near:
            store3(kept, found, 0, a)
            found += 1
        if (a[2] >= near) != (b[2] >= near):
            inner, outer = (a, b) if a[2] >= near else (b, a)
            share = (inner[2] - near) / (inner[2] - outer[2])
            x = axpy(share, sub(outer, inner), inner)
            store3(kept, found, 0, (x[0], x[1], near))
            found += 1
    return found


@kernel
def draw_polygon(screen: Screen, count: int, corner: Floats, n: Vec, tag: int, kept: Floats) -> None:
    """Draw a convex polygon with corners (count, 3) m in E and the normal n; kept: room for two corners more."""
    pinhole = screen.pinhole
    e = dot(n, load3(corner, 0, 0))
    left_over = clip_near(count, corner, pinhole[0, 4], kept)
    if e == 0.0 or left_over < 3:
        return
    top, bottom = math.inf, -math.inf
    for k in range(left_over):
        x, y, z = load3(kept, k, 0)
        px, py = pinhole[0, 2] + pinhole[0, 0] * x / z, pinhole[0, 3] + pinhole[0, 1] * y / z
        px, py = math.floor(px * GRID + 0.5) / GRID, math.floor(py * GRID + 0.5) / GRID
        kept[k, 0], kept[k, 1] = px, py
        top, bottom = min(top, py), max(bottom, py)
    first_row, last_row = pixel_range(top, bottom, len(screen.v))
    for j in range(first_row, last_row):
        line, left, right = j + 0.5, math.inf, -math.inf
        for k in range(left_over):
            m = k + 1 if k + 1 < left_over else 0
            up, down = (k, m) if kept[k, 1] <= kept[m, 1] else (m, k)
            if kept[up, 1] <= line and line < kept[down, 1]:
                slope = (kept[down, 0] - kept[up, 0]) / (kept[down, 1] - kept[up, 1])
                x = kept[up, 0] + (line - kept[up, 1]) * slope
                left, right = min(left, x), max(right, x)
        first, last = pixel_range(left, right, len(screen.u))
        flat_row(row_of(screen, j, 0.0, first, last), n, e, tag)
