"""Balls, ellipsoids, cylinders and capsules on the screen: the rectangle of pixels that each may cover, and its rows.

Source: Mara, McGuire, 2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere, 2013 (tangents in a plane).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.images.scanlines import ball_end_row, ball_row, cap_row, ellipsoid_row, side_row
from plumbline.engine.images.screen import Screen, pixel_range, row_of
from plumbline.engine.maths.rows import Floats, Mat, Vec
from plumbline.engine.maths.vec import axpy, dot, neg

Window = tuple[float, float, float, float]
"""Left, right, upper and lower end in units of the focal lengths."""
EVERYTHING = (-math.inf, math.inf, -math.inf, math.inf)
NOTHING = (math.inf, -math.inf, math.inf, -math.inf)


@kernel
def tangents(x: float, z: float, radius: float) -> tuple[float, float]:
    """The slopes x/z of the two lines through the origin that touch the circle about (x, z), which lies before it."""
    across, depth2 = radius * math.sqrt(x * x + z * z - radius * radius), (z - radius) * (z + radius)
    return (x * z - across) / depth2, (x * z + across) / depth2


@kernel
def ball_window(c: Vec, radius: float, near: float) -> Window:
    """What the ball may cover: all if it reaches over the near plane, nothing behind it."""
    if c[2] + radius < near:
        return NOTHING
    if c[2] - radius < near:
        return EVERYTHING
    left, right = tangents(c[0], c[2], radius)
    top, bottom = tangents(c[1], c[2], radius)
    return left, right, top, bottom


@kernel
def tube_window(a: Vec, b: Vec, radius: float, near: float) -> Window:
    """What may be covered by all that lies between two balls; where one of them is cut, nothing bounds it."""
    if max(a[2], b[2]) + radius < near:
        return NOTHING
    if min(a[2], b[2]) - radius < near:
        return EVERYTHING
    one, two = ball_window(a, radius, near), ball_window(b, radius, near)
    return min(one[0], two[0]), max(one[1], two[1]), min(one[2], two[2]), max(one[3], two[3])


@kernel
def pixels_of(window: Window, screen: Screen) -> tuple[int, int, int, int]:
    """First and last column, first and last row, with a pixel to spare on each side against rounding."""
    pinhole, u, v = screen.pinhole, screen.u, screen.v
    left, right = pixel_range(
        pinhole[0, 2] + pinhole[0, 0] * window[0] - 1.0, pinhole[0, 2] + pinhole[0, 0] * window[1] + 1.0, len(u)
    )
    top, bottom = pixel_range(
        pinhole[0, 3] + pinhole[0, 1] * window[2] - 1.0, pinhole[0, 3] + pinhole[0, 1] * window[3] + 1.0, len(v)
    )
    return left, right, top, bottom


@kernel
def ball_span(c: Vec, radius: float, y: float, pinhole: Floats, left: int, right: int) -> tuple[int, int]:
    """The columns of a row in which the outline of a ball that lies before the near plane runs, a pixel to spare.

    The outline is the conic (d . c)^2 = |d|^2 (c^2 - r^2).
    """
    outside, rest = dot(c, c) - radius * radius, y * c[1] + c[2]
    a, b = c[0] * c[0] - outside, c[0] * rest
    root = b * b - a * (rest * rest - outside * (y * y + 1.0))
    if root < 0.0 or a >= 0.0:
        return left, right
    root = math.sqrt(root)
    first, last = pixel_range(
        pinhole[0, 2] + pinhole[0, 0] * (-b + root) / a - 1.0, pinhole[0, 2] + pinhole[0, 0] * (-b - root) / a + 1.0, right
    )
    return max(first, left), last


@kernel
def draw_ball(screen: Screen, c: Vec, radius: float, tag: int) -> None:
    """Draw the ball about c [m] in E."""
    near = screen.pinhole[0, 4]
    left, right, top, bottom = pixels_of(ball_window(c, radius, near), screen)
    whole = c[2] - radius >= near
    for j in range(top, bottom):
        first, last = ball_span(c, radius, screen.v[j], screen.pinhole, left, right) if whole else (left, right)
        ball_row(first, last, row_of(screen, j, near), c, radius, tag)


@kernel
def draw_ellipsoid(screen: Screen, c: Vec, m: Mat, semi_axes: Vec, tag: int) -> None:
    """Draw the ellipsoid about c, its axes the columns of m, in E: within the rectangle of the ball that holds it."""
    near, (a, b, d) = screen.pinhole[0, 4], semi_axes
    left, right, top, bottom = pixels_of(ball_window(c, max(a, b, d), near), screen)
    shrink = (m[0] / a, m[3] / a, m[6] / a, m[1] / b, m[4] / b, m[7] / b, m[2] / d, m[5] / d, m[8] / d)
    for j in range(top, bottom):
        ellipsoid_row(left, right, row_of(screen, j, near), c, shrink, tag)


@kernel
def draw_cylinder(screen: Screen, c: Vec, a: Vec, radius: float, half: float, tag: int) -> None:
    """Draw the cylinder about c along a: its side, then the ends with the tags that follow."""
    near, up, low = screen.pinhole[0, 4], axpy(half, a, c), axpy(-half, a, c)
    left, right, top, bottom = pixels_of(tube_window(up, low, radius, near), screen)
    for j in range(top, bottom):
        side_row(left, right, row_of(screen, j, near), c, a, radius, half, tag)
    for end in range(2):
        middle = up if end == 0 else low
        left, right, top, bottom = pixels_of(ball_window(middle, radius, near), screen)
        for j in range(top, bottom):
            cap_row(left, right, row_of(screen, j, near), middle, a, radius, tag + 1 + end)


@kernel
def draw_capsule(screen: Screen, c: Vec, a: Vec, radius: float, half: float, tag: int) -> None:
    """Draw the capsule about c along a: the side, and the balls at its ends, whose inner halves the side hides."""
    near, up, low = screen.pinhole[0, 4], axpy(half, a, c), axpy(-half, a, c)
    left, right, top, bottom = pixels_of(tube_window(up, low, radius, near), screen)
    for j in range(top, bottom):
        side_row(left, right, row_of(screen, j, near), c, a, radius, half, tag)
    if min(up[2], low[2]) - radius >= near:
        draw_ball(screen, up, radius, tag)
        draw_ball(screen, low, radius, tag)
        return
    for end in range(2):
        middle, out = (up, a) if end == 0 else (low, neg(a))
        left, right, top, bottom = pixels_of(ball_window(middle, radius, near), screen)
        for j in range(top, bottom):
            ball_end_row(left, right, row_of(screen, j, near), middle, radius, out, tag)
