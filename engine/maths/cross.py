"""The cross product of two vectors where worlds are built: one by one, for thousands of triangles."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["cross"]


def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """a x b of two vectors (3,), as `np.cross` rounds it, in less than a tenth of its time."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])
