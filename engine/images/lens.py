"""The directions in which pixels look, through a pinhole and its lens.

Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32, 1966.
"""

import math

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import hypot
from plumbline.engine.maths.rows import Floats, load9, store3
from plumbline.engine.maths.vec import mat_vec

RESIDUAL = 1e-12
"""Largest distance [1] of a distorted direction from the pixel that it belongs to."""
ITERATIONS = 50
K1, K2, K3, P1, P2, FOLD = 17, 18, 19, 20, 21, 22
"""Columns of an eye's row."""


@kernel
def distort(x: float, y: float, eye: Floats) -> tuple[float, float, float, float, float]:
    """Where the lens shows the direction (x, y, 1), and the derivatives of that: d x'/d x, d x'/d y = d y'/d x, d y'/d y."""
    k1, k2, k3, p1, p2 = eye[0, K1], eye[0, K2], eye[0, K3], eye[0, P1], eye[0, P2]
    r2 = x * x + y * y
    grow, slope = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)), 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2))
    return (
        x * grow + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * grow + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        grow + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
        slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y,
        grow + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
    )


@kernel
def undistort(u: float, v: float, eye: Floats) -> tuple[float, float, bool]:
    """The direction (x, y, 1) that the lens shows at (u, v), by Newton's method, steps halved while they lead away.

    Returns: x, y, and whether the residual is below RESIDUAL on this side of the fold.
    """
    x, y = u, v
    if x * x + y * y > 0.64 * eye[0, FOLD] * eye[0, FOLD]:
        x, y = 0.0, 0.0
    a, b, xx, xy, yy = distort(x, y, eye)
    miss = hypot(a - u, b - v)
    for _ in range(ITERATIONS):
        if miss == 0.0:
            break
        det = xx * yy - xy * xy
        dx, dy = (yy * (a - u) - xy * (b - v)) / det, (xx * (b - v) - xy * (a - u)) / det
        share = 1.0
        while share > 1e-6:
            c, d = x - share * dx, y - share * dy
            a, b, xx, xy, yy = distort(c, d, eye)
            if hypot(a - u, b - v) < miss and c * c + d * d <= eye[0, FOLD] * eye[0, FOLD]:
                break
            share *= 0.5
        if share <= 1e-6:
            break
        x, y, miss = c, d, hypot(a - u, b - v)
    _, _, xx, xy, yy = distort(x, y, eye)
    return x, y, miss <= RESIDUAL and xx * yy > xy * xy


@entry
def look(eye: Floats, width: int, first_row: int, rows: int, x: float, y: float, directions: Floats, length: Floats) -> int:
    """Write directions (n, 3) in W with unit z in E, of the point (x, y) in each pixel of some rows, and their lengths (n,).

    Returns: the first pixel, counted from the first of these rows, that the lens shows nothing at, or -1.
    """
    turn = load9(eye, 0, 3)
    curved = eye[0, K1] != 0.0 or eye[0, K2] != 0.0 or eye[0, K3] != 0.0 or eye[0, P1] != 0.0 or eye[0, P2] != 0.0
    for j in range(rows):
        v = (first_row + j + y - eye[0, 15]) / eye[0, 13]
        for i in range(width):
            u, w, good = (i + x - eye[0, 14]) / eye[0, 12], v, True
            if curved:
                u, w, good = undistort(u, v, eye)
            if not good:
                return j * width + i
            store3(directions, j * width + i, 0, mat_vec(turn, (u, w, 1.0)))
            length[j * width + i] = math.sqrt(u * u + w * w + 1.0)
    return -1
