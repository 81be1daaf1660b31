"""Newton on Coulomb's law itself, without convexity: the last steps from near a solution.

With mu = 1 in scaled variables and tau = x - (W x + q), the law of Alart and Curnier reads

    x_N = max(tau_N, 0),  x_T = the point of the disc of radius max(tau_N, 0) nearest to tau_T,

piecewise smooth. From far away these steps fail; near by, with the right set of open, sticking and slipping contacts, they
converge quadratically.

Source: Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

__all__ = ["finishing_step"]

FloatArray = NDArray[np.float64]

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)


def finishing_step(w: FloatArray, q: FloatArray, rubs: NDArray[np.bool_], x: FloatArray) -> FloatArray | None:
    """The impulses (k, 3) after one step, or None where the system is singular.

    Args: w (3k, 3k), regularised, and q (k, 3) scaled to order one and to mu = 1; rubs (k,): contacts with friction; x (k, 3).
    """
    k = len(x)
    tau = x - q - (w @ x.ravel()).reshape(-1, 3)
    normal, size = np.maximum(tau[:, 0], 0.0), np.hypot(tau[:, 1], tau[:, 2])
    slips = size > normal
    share = np.where(rubs, np.where(slips, normal / np.maximum(size, 1e-300), 1.0), 0.0)
    tangent = tau[:, 1:] / np.maximum(size, 1e-300)[:, None]
    law = np.concatenate([normal[:, None], share[:, None] * tau[:, 1:]], axis=1)
    slope = np.zeros((k, 3, 3))
    slope[:, 0, 0] = tau[:, 0] > 0.0
    slides = rubs & slips & (tau[:, 0] > 0.0)
    slope[:, 1, 1] = slope[:, 2, 2] = share
    slope[slides, 1:, 0] = tangent[slides]
    slope[slides, 1:, 1:] -= share[slides, None, None] * tangent[slides, :, None] * tangent[slides, None, :]
    matrix = (slope @ (w - np.eye(3 * k)).reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k)
    matrix[np.arange(3 * k), np.arange(3 * k)] += 1.0
    _, _, step, status = gesv(matrix, (law - x).ravel())
    if status != 0 or not np.isfinite(step).all():
        return None
    return x + np.asarray(step, np.float64).reshape(-1, 3)
