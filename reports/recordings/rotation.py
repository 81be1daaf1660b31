"""Quaternions (w, x, y, z) of whole arrays: product, rotation of vectors, and the angle between two."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[Any]


def product(a: Floats, b: Floats) -> Floats:
    """Hamilton product, shapes (..., 4) broadcast against each other."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    s, i, j, k = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            w * s - x * i - y * j - z * k,
            w * i + x * s + y * k - z * j,
            w * j - x * k + y * s + z * i,
            w * k + x * j - y * i + z * s,
        ],
        axis=-1,
    )


def rotate(q: Floats, v: Floats) -> Floats:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    # Component by component: np.cross takes three times as long for as many small vectors.
    w, x, y, z = np.moveaxis(q, -1, 0)
    a, b, c = np.moveaxis(v, -1, 0)
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack([a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i], axis=-1)


def compose(p_WB: Floats, q_WB: Floats, p_BS: Floats, q_BS: Floats) -> tuple[Floats, Floats]:
    """The pose p_WS, q_WS of a frame S that sits at p_BS, q_BS in the body frame B."""
    return p_WB + rotate(q_WB, np.broadcast_to(p_BS, p_WB.shape)), product(q_WB, q_BS)


def angle(a: Floats, b: Floats) -> Floats:
    """The angle [rad] of the rotation between two attitudes, in 0..pi, shapes (..., 4).

    Source:
        Huynh, Metrics for 3D rotations, Journal of Mathematical Imaging and Vision 35 (2009), with atan2 for small angles.
    """
    apart = np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)
    return np.asarray(4.0 * np.arctan2(np.minimum(*apart), np.maximum(*apart)))
