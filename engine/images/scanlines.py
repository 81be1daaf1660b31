"""Depths along one row of pixels: of a plane, a ball, the side of a cylinder and its end.

With pixel coordinates u, v in units of the focal length, a point is z d, d = (u, v, 1). Whatever decides about a pixel is then
a polynomial of u of degree two at most, so that a row is one loop without a branch. The discriminants are Lagrange's identity,
r^2 |d|^2 - |d x c|^2, which does not cancel for far and small things.

Source: Sigg, Weyrich, Botsch, Gross, GPU-Based Ray-Casting of Quadratic Surfaces, 2006, sections 3 and 4 (quadrics by pixels,
in homogeneous form); Heckbert, Moreton, Interpolation for Polygon Texture Mapping and Shading, 1991 (1/z is linear on screen).
"""

import math

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.images.screen import Row
from plumbline.engine.maths.rows import Mat, Vec
from plumbline.engine.maths.vec import cross, dot, mat_vec


@kernel
def root_of(x: float) -> float:
    """The square root, NaN below zero, which loses every comparison."""
    return math.sqrt(x) if x >= 0.0 else math.nan


@stream
def flat_row(first: int, last: int, row: Row, n: Vec, e: float, tag: int) -> None:
    """The plane n . x = e [m]."""
    u, v, near, z, who = row
    rest = n[1] * v + n[2]
    for i in range(first, last):
        depth = e / (n[0] * u[i] + rest)
        closer = (depth >= near) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]


@stream
def ball_row(first: int, last: int, row: Row, c: Vec, radius: float, tag: int) -> None:
    """The ball about c: its near side, or its far side where the near one lies before `near`."""
    u, v, near, z, who = row
    square, rest2, rest = radius * radius, v * v + 1.0, v * c[1] + c[2]
    x2 = (v * c[2] - c[1]) * (v * c[2] - c[1])
    for i in range(first, last):
        d2, middle = u[i] * u[i] + rest2, u[i] * c[0] + rest
        y, w = c[0] - u[i] * c[2], u[i] * c[1] - v * c[0]
        root = root_of(square * d2 - (x2 + y * y + w * w))
        front, back = (middle - root) / d2, (middle + root) / d2
        depth = front if front >= near else back
        closer = (depth >= near) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]


@stream
def ellipsoid_row(first: int, last: int, row: Row, c: Vec, shrink: Mat, tag: int) -> None:
    """As `ball_row`, of the ellipsoid about c that `shrink` [1/m] takes to a unit ball: its axes as rows over its semi-axes."""
    u, v, near, z, who = row
    p = mat_vec(shrink, c)
    rest = mat_vec(shrink, (0.0, v, 1.0))
    for i in range(first, last):
        dx, dy, dz = u[i] * shrink[0] + rest[0], u[i] * shrink[3] + rest[1], u[i] * shrink[6] + rest[2]
        d2, middle = dx * dx + dy * dy + dz * dz, dx * p[0] + dy * p[1] + dz * p[2]
        x, y, w = dy * p[2] - dz * p[1], dz * p[0] - dx * p[2], dx * p[1] - dy * p[0]
        root = root_of(d2 - (x * x + y * y + w * w))
        front, back = (middle - root) / d2, (middle + root) / d2
        depth = front if front >= near else back
        closer = (depth >= near) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]


@stream
def ball_end_row(first: int, last: int, row: Row, c: Vec, radius: float, a: Vec, tag: int) -> None:
    """As `ball_row`, only the half of the ball on the side of the unit vector a: for a capsule seen from within."""
    u, v, near, z, who = row
    square, rest2, rest = radius * radius, v * v + 1.0, v * c[1] + c[2]
    x2 = (v * c[2] - c[1]) * (v * c[2] - c[1])
    rise, least = v * a[1] + a[2], dot(a, c) - 1e-12 * radius
    for i in range(first, last):
        d2, middle = u[i] * u[i] + rest2, u[i] * c[0] + rest
        y, w = c[0] - u[i] * c[2], u[i] * c[1] - v * c[0]
        root = root_of(square * d2 - (x2 + y * y + w * w))
        front, back, up = (middle - root) / d2, (middle + root) / d2, u[i] * a[0] + rise
        depth = front if (front >= near) & (front * up >= least) else back
        closer = (depth >= near) & (depth * up >= least) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]


@stream
def side_row(first: int, last: int, row: Row, c: Vec, a: Vec, radius: float, half: float, tag: int) -> None:
    """The side of the cylinder about c along the unit vector a, its far side where the near one is cut away."""
    u, v, near, z, who = row
    square, out, level = radius * radius, cross(c, a), dot(c, a)
    x = v * a[2] - a[1]
    for i in range(first, last):
        y, w = a[0] - u[i] * a[2], u[i] * a[1] - v * a[0]
        d2, middle, aside = x * x + y * y + w * w, x * out[0] + y * out[1] + w * out[2], u[i] * out[0] + v * out[1] + out[2]
        root, up = root_of(square * d2 - aside * aside), u[i] * a[0] + v * a[1] + a[2]
        front, back = (middle - root) / d2, (middle + root) / d2
        depth = front if (front >= near) & (abs(front * up - level) <= half) else back
        closer = (depth >= near) & (abs(depth * up - level) <= half) & (depth < z[i])
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]


@stream
def cap_row(first: int, last: int, row: Row, c: Vec, a: Vec, radius: float, tag: int) -> None:
    """The disc about c at right angles to a."""
    u, v, near, z, who = row
    square, e, rest = radius * radius, dot(a, c), v * a[1] + a[2]
    for i in range(first, last):
        depth = e / (u[i] * a[0] + rest)
        x, y, w = depth * u[i] - c[0], depth * v - c[1], depth - c[2]
        closer = (depth >= near) & (depth < z[i]) & (x * x + y * y + w * w <= square)
        z[i] = depth if closer else z[i]
        who[i] = tag if closer else who[i]
