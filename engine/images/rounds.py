"""Balls, ellipsoids, cylinders and capsules on the screen: the pixels that each may cover, and the rays through these.

A ray that starts inside, where the near plane cuts a shape open, sees the far side.

Source: Mara, McGuire, 2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere, 2013 (tangents in a plane).
"""

import math
from collections.abc import Callable

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.images.screen import Row, Screen, pixel_range, row_of
from plumbline.engine.maths.rows import Floats, Vec
from plumbline.engine.maths.vec import axpy, dot, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.rays.streams import Form, Primitive, to_capsule, to_cylinder, to_ellipsoid

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
def ball_window(c: Vec, radius: float) -> Window:
    """What a ball before the near plane may cover."""
    left, right = tangents(c[0], c[2], radius)
    top, bottom = tangents(c[1], c[2], radius)
    return left, right, top, bottom


@kernel
def tube_window(a: Vec, b: Vec, radius: float, near: float) -> Window:
    """What all between two balls may cover: nothing behind the near plane, all where one of them reaches over it."""
    if max(a[2], b[2]) + radius < near:
        return NOTHING
    if min(a[2], b[2]) - radius < near:
        return EVERYTHING
    one, two = ball_window(a, radius), ball_window(b, radius)
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


def _over_row(form: Form) -> Callable[[Row, Primitive, int], None]:
    """The stream that draws the rays of a row, which start on the near plane, as far as a closed form lets them go."""

    def round_row(row: Row, shape: Primitive, tag: int) -> None:
        u, v, near, z, who = row
        c, m = shape.centre, shape.axes
        for i in range(len(u)):
            o, d = tmat_vec(m, (near * u[i] - c[0], near * v - c[1], near - c[2])), tmat_vec(m, (u[i], v, 1.0))
            depth = near + form(o, d, shape.size)
            closer = depth < z[i]
            z[i] = depth if closer else z[i]
            who[i] = tag if closer else who[i]

    return stream(round_row)


ellipsoid_row, capsule_row, cylinder_row = map(_over_row, (to_ellipsoid, to_capsule, to_cylinder))


@kernel
def draw_round(screen: Screen, shape: Primitive, tag: int) -> None:
    """Draw a shape that stands in E."""
    near, c, m = screen.pinhole[0, 4], shape.centre, shape.axes
    ball = shape.kind == at.ELLIPSOID
    half, radius = 0.0 if ball else shape.size[1], shape.ball if ball else shape.size[0]
    a = (m[2], m[5], m[8])
    left, right, top, bottom = pixels_of(tube_window(axpy(half, a, c), axpy(-half, a, c), radius, near), screen)
    for j in range(top, bottom):
        first, last = left, right
        if c[2] - shape.ball >= near:
            first, last = ball_span(c, shape.ball, screen.v[j], screen.pinhole, left, right)
        row = row_of(screen, j, near, first, last)
        if ball:
            ellipsoid_row(row, shape, tag)
        elif shape.kind == at.CAPSULE:
            capsule_row(row, shape, tag)
        else:
            cylinder_row(row, shape, tag)
