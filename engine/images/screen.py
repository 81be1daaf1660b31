"""The pixels that a rasteriser draws into, and rows of them: the rays that look through these, and the depths that stay.

With pixel coordinates u, v in units of the focal length, a point that a pixel sees is z d, d = (u, v, 1), at the depth z.

Source: Heckbert, Moreton, Interpolation for Polygon Texture Mapping and Shading, 1991 (1/z is linear on screen).
"""

import math
from typing import NamedTuple

import numpy as np

from plumbline.engine.compile.jit import inlined, kernel, stream
from plumbline.engine.maths.rows import Floats, Ints, Vec


class Screen(NamedTuple):
    """A picture that is drawn, h rows of w pixels.

    Terms:
        pinhole (1, 5): focal lengths and centre [pixels], z-depth before which nothing is seen [m]; u (w,), v (h,): columns and
        rows in units of the focal lengths; depth (h, w) m along z of E; tags (h, w): what is drawn, -1 for nothing.
    """

    pinhole: Floats
    u: Floats
    v: Floats
    depth: Floats
    tags: Ints


class Row(NamedTuple):
    """Pixels of one row of a screen, v in units of the focal length, and the z-depth [m] from which on it is drawn into."""

    u: Floats
    v: float
    near: float
    depth: Floats
    tags: Ints


@kernel
def screen_of(pinhole: Floats, depth: Floats, tags: Ints) -> Screen:
    """An empty screen of the size of `depth` and `tags`, which it writes into."""
    height, width = depth.shape
    u, v = np.empty(width), np.empty(height)
    for i in range(width):
        u[i] = (i + 0.5 - pinhole[0, 2]) / pinhole[0, 0]
    for j in range(height):
        v[j] = (j + 0.5 - pinhole[0, 3]) / pinhole[0, 1]
    for j in range(height):
        for i in range(width):
            depth[j, i], tags[j, i] = math.inf, -1
    return Screen(pinhole, u, v, depth, tags)


@inlined
def row_of(screen: Screen, j: int, near: float, first: int, last: int) -> Row:
    """Pixels first..last - 1 of row j, drawn into from the z-depth `near` [m] on."""
    return Row(screen.u[first:last], screen.v[j], near, screen.depth[j][first:last], screen.tags[j][first:last])


@kernel
def pixel_range(low: float, high: float, count: int) -> tuple[int, int]:
    """The pixels of a row of `count` whose centres lie in low <= x < high, from the first to the one after the last."""
    first, last = math.ceil(min(max(low - 0.5, 0.0), float(count))), math.ceil(min(max(high - 0.5, 0.0), float(count)))
    return int(first), int(last)


@stream
def flat_row(row: Row, n: Vec, e: float, tag: int) -> None:
    """Draw the plane n . x = e [m]."""
    u, v, near, z, who = row
    rest = n[1] * v + n[2]
    for i in range(len(u)):
        depth = e / (n[0] * u[i] + rest)
        closer = (depth >= near) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]
