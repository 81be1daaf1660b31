"""Path following on Coulomb's law itself: all contacts blurred at first, then sharper and sharper.

Smoothed with a width w, De Saxce's form reads F(x) = p(x - y(x)) - x = 0 with the smoothed projection p and

    y = W x + q + (sqrt(|y_T|^2 + w^2), 0, 0)

in variables with mu = 1. Unlike the convex problems it has their coupling between sliding and normal velocity inside, so its
matrix is not symmetric and a path may turn back. Where forces are not unique it stays near the middle of the cones.

Source: Fukushima, Luo, Tseng, SIAM J. Optim. 12, 2002 (smoothing); De Saxce, Feng, Math. Comput. Modelling 28, 1998.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.cone import inverse_slope, smooth_project
from plumbline.engine.respond.exact.effort import FOLLOWED, Effort

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

PROXIMAL = 1e-11
"""Added to the diagonal for the steps alone: where forces are not unique they stay where they are."""
PATIENCE = 3
"""Widths that may end without convergence before the path is given up."""
STEPS, SHRINK = 20, 0.4
"""Newton steps allowed for each width, and the factor from one width to the next."""


def follow_path(
    w: Floats, q: Floats, rubs: NDArray[np.bool_], x: Floats, width: float, narrowest: float, effort: Effort
) -> Floats:
    """Impulses at the end of the path.

    Args: w (3k, 3k) and q (k, 3) scaled to order one and to mu = 1; rubs (k,): contacts with friction; x (k, 3):
        where to start; width, narrowest: the first and the last width; effort: what is left.
    Returns: impulses (k, 3).
    """
    k, slow = len(x), 0
    one = np.eye(3 * k)
    regular = w + PROXIMAL * one

    def lifted(x: Floats) -> tuple[Floats, Floats, Floats]:
        y = q + (w @ x.ravel()).reshape(-1, 3)
        y[~rubs, 1:] = 0.0
        size = np.sqrt(y[:, 1] ** 2 + y[:, 2] ** 2 + width * width)
        direction = y[:, 1:] / size[:, None]
        y[:, 0] += np.where(rubs, size, 0.0)
        z = x - y
        return z, direction, smooth_project(z, width) - x

    while True:
        z, direction, miss = lifted(x)
        for _ in range(STEPS):
            error = float(np.abs(miss).max())
            if error <= 0.1 * width:
                break
            if not effort.take(FOLLOWED):
                return x
            values, frame = inverse_slope(z, width)
            slope = (frame / values[:, None, :]) @ np.swapaxes(frame, 1, 2)
            rows = regular.reshape(k, 3, 3 * k).copy()
            rows[:, 0] += direction[:, 0, None] * rows[:, 1] + direction[:, 1, None] * rows[:, 2]
            matrix = one - (slope @ (one.reshape(k, 3, 3 * k) - rows)).reshape(3 * k, 3 * k)
            _, _, step, status = gesv(matrix, miss.ravel())
            if status != 0 or not np.isfinite(step).all():
                return x
            way, size, start = np.asarray(step).reshape(-1, 3), 1.0, float((miss * miss).sum())
            way[~rubs, 1:] = 0.0
            for _ in range(8):
                z, direction, miss = lifted(x + size * way)
                if float((miss * miss).sum()) < (1.0 - 1e-4 * size) * start:
                    break
                size *= 0.5
            x = x + size * way
        else:
            slow += 1
        if slow > PATIENCE or width <= narrowest:
            return x
        width = max(SHRINK * width, narrowest)
