"""Brown's lens distortion of normalised image coordinates, and its inverse by Newton's method.

Newton starts from the distorted point itself and stops at a residual of RESIDUAL or of a few roundings of the point, whichever
is larger; for a lens of a few per cent that takes four or five steps. Only the branch on which the map keeps its handedness
belongs to the lens: beyond it a strong polynomial folds the picture back on itself, and no ray comes to such a point.

Source: Brown, Decentering Distortion of Lenses, Photogrammetric Engineering 32 (1966) 444.
"""

import numpy as np

from plumbline.harness.scene import Distortion
from plumbline.harness.trajectory import Floats

RESIDUAL = 1e-14
"""Greatest distance [1], beside rounding, between a point and the distorted image of what `undistort` gives for it."""
STEPS = 50


def distort(lens: Distortion, points: Floats) -> Floats:
    """Distorted coordinates (..., 2) [1] of normalised ones (..., 2) [1], x to the right and y down; see `Distortion`."""
    x, y = points[..., 0], points[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (lens.k1 + square * (lens.k2 + square * lens.k3))
    return np.stack(
        [
            x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (square + 2.0 * x * x),
            y * radial + lens.p1 * (square + 2.0 * y * y) + 2.0 * lens.p2 * x * y,
        ],
        axis=-1,
    )


def _slopes(lens: Distortion, points: Floats) -> tuple[Floats, Floats, Floats]:
    """dx'/dx, dx'/dy = dy'/dx and dy'/dy of `distort`."""
    x, y = points[..., 0], points[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (lens.k1 + square * (lens.k2 + square * lens.k3))
    grows = 2.0 * (lens.k1 + square * (2.0 * lens.k2 + square * 3.0 * lens.k3))
    return (
        radial + x * x * grows + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x,
        x * y * grows + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
        radial + y * y * grows + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x,
    )


def undistort(lens: Distortion, points: Floats) -> Floats:
    """The normalised coordinates (..., 2) [1] whose distorted image the given ones (..., 2) [1] are.

    Raises:
        ValueError: no ray that this lens lets through comes to one of the points.
    """
    wanted = np.asarray(points, dtype=np.float64)
    undistorted = wanted.copy()
    allowed = RESIDUAL + 16.0 * np.finfo(np.float64).eps * np.linalg.norm(wanted, axis=-1)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            missed = distort(lens, undistorted) - wanted
            if (np.linalg.norm(missed, axis=-1) <= allowed).all():
                break
            xx, xy, yy = _slopes(lens, undistorted)
            step = np.stack([yy * missed[..., 0] - xy * missed[..., 1], xx * missed[..., 1] - xy * missed[..., 0]], axis=-1)
            undistorted = undistorted - step / (xx * yy - xy * xy)[..., None]
        missed = distort(lens, undistorted) - wanted
        xx, xy, yy = _slopes(lens, undistorted)
        good = (np.linalg.norm(missed, axis=-1) <= allowed) & (xx * yy - xy * xy > 0.0) & (xx + yy > 0.0)
    if not good.all():
        first = wanted.reshape(-1, 2)[int(np.flatnonzero(~good.ravel())[0])]
        raise ValueError(f"distortion {lens}: no ray comes to the normalised point ({first[0]:g}, {first[1]:g}), expected one")
    return undistorted
