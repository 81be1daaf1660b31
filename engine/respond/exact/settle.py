"""Newton with the mode of every contact given: the last steps from a point of a path.

Along a path impulses that vanish in the limit do so like w^2, all others tend to constants. The logarithmic derivative of both
spectral values of an impulse, 2 or 0, therefore tells open contacts (both vanish), slipping ones (the lower vanishes) and
sticking ones, whatever the scale of their velocities; a comparison of impulse and velocity would need their scales. Where a
convex problem is solved to 1e-13, all that vanishes is below what does not, and the comparison serves. With the modes,

    open: x = 0,    sticking: u = 0,    slipping: u_N = 0 and x_T = -x_N u_T / |u_T|

is a smooth system. Where impulses are not unique they stay near those of the path, inside the cones.

Source: El-Bakry, Tapia, Zhang, A study of indicators for identifying zero variables in interior-point methods, SIAM Rev. 36,
1994.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.respond.exact.cone import spectral

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

OPEN, STICKING, SLIPPING = 0, 1, 2


def modes_of(rubs: NDArray[np.bool_], x: Floats, drift: Floats) -> Ints:
    """The modes (k,) of contacts at a point of a path. Args: rubs (k,): with friction; x, drift (k, 3): see `PathPoint`."""
    low, high, tangent = spectral(x)
    along = (drift[:, 1:] * tangent).sum(axis=1)
    vanishes, slips = drift[:, 0] + along > high, (drift[:, 0] - along > low) & rubs
    return np.where(vanishes, OPEN, np.where(slips, SLIPPING, STICKING))


def modes_between(rubs: NDArray[np.bool_], x: Floats, y: Floats) -> Ints:
    """The modes (k,) of contacts where x (k, 3) and y (k, 3) are complementary: of each pair the smaller one vanishes.

    Ends of one spectral frame are the lower value of one and the higher value of the other.
    """
    (low, high, _), (below, above, _) = spectral(x), spectral(y)
    return np.where(high < below, OPEN, np.where((low < above) & rubs, SLIPPING, STICKING))


def settling_step(w: Floats, q: Floats, rubs: NDArray[np.bool_], mode: Ints, x: Floats) -> Floats | None:
    """The impulses (k, 3) after one step, or None where the system is singular.

    Args: as `finishing_step`; mode (k,).
    """
    k, n = len(x), 3 * len(x)
    y = q + (w @ x.ravel()).reshape(-1, 3)
    speed = np.hypot(y[:, 1], y[:, 2])
    away = y[:, 1:] / np.maximum(speed, 1e-300)[:, None]
    closed, sticks, slips = mode != OPEN, (mode == STICKING) & rubs, mode == SLIPPING
    # The law of each contact is of_y dy + of_x dx = -miss.
    of_y, of_x, miss = np.zeros((k, 3, 3)), np.zeros((k, 3, 3)), x.copy()
    of_x[:] = np.eye(3)
    of_x[closed, 0, 0], of_y[closed, 0, 0], miss[closed, 0] = 0.0, 1.0, y[closed, 0]
    of_x[sticks], of_y[sticks], miss[sticks] = 0.0, np.eye(3), y[sticks]
    of_x[slips, 1:, 0] = away[slips]
    miss[slips, 1:] += x[slips, :1] * away[slips]
    across = np.eye(2) - away[slips, :, None] * away[slips, None, :]
    of_y[slips, 1:, 1:] = (x[slips, 0] / np.maximum(speed[slips], 1e-300))[:, None, None] * across
    matrix = (of_y @ w.reshape(k, 3, n)).reshape(n, n)
    each = np.arange(k)
    matrix.reshape(k, 3, k, 3)[each, :, each, :] += of_x
    # Slip by small velocities has large rows.
    largest = np.maximum(np.abs(matrix).max(axis=1), 1e-300)
    _, _, step, status = gesv(matrix / largest[:, None], -miss.ravel() / largest)
    if status != 0 or not np.isfinite(step).all():
        return None
    return x + np.asarray(step, np.float64).reshape(-1, 3)
