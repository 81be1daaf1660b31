"""Path following on Coulomb's law itself: all contacts blurred at first, then sharper and sharper.

Smoothed with a width w, De Saxce's form reads F(x) = p(x - y(x)) - x = 0 with the smoothed projection p and

    y = W x + q + (|y_T|^2 / sqrt(|y_T|^2 + w^2), 0, 0)

in variables with mu = 1. Unlike the convex problems it has their coupling between sliding and normal velocity inside, so its
matrix is not symmetric and a path may turn back. Where forces are not unique it stays near the middle of the cones. The
smoothing of |y_T| shifts a sticking contact by nothing and a sliding one by w^2: a jammed body is not loosened by it.

With c = p(z) - z, F is p - x where a contact is open and c - y where it bears, and 1 - dp/dz comes from c alone: differences of
large numbers would cost the digits that decide who slips.

Source: Fukushima, Luo, Tseng, SIAM J. Optim. 12, 2002 (smoothing); De Saxce, Feng, Math. Comput. Modelling 28, 1998.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from engine.exact.cone import compose, frame_of, root, spectral

__all__ = ["follow_path"]

FloatArray = NDArray[np.float64]

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

PROXIMAL = 1e-9
"""Added to the diagonal for the steps alone: where forces are not unique they stay where they are."""
PATIENCE = 4
"""Widths that may end without convergence before the path is given up."""
STEPS, SHRINK = 20, 0.4
"""Newton steps allowed for each width, and the factor from one width to the next."""


def follow_path(
    w: FloatArray, q: FloatArray, rubs: NDArray[np.bool_], x: FloatArray, width: float, narrowest: float
) -> Iterator[tuple[FloatArray, float, int]]:
    """Impulses (k, 3) at the end of each width, with the width and the Newton steps it took.

    Args: w (3k, 3k) and q (k, 3) scaled to order one and to mu = 1; rubs (k,): contacts with friction; x (k, 3):
        where to start; width, narrowest: the first and the last width.
    """
    k, slow = len(x), 0
    regular, each = w + PROXIMAL * np.eye(3 * k), np.arange(k)

    def missed(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """z, d |y_T| / d y_T and F."""
        y = q + (w @ x.ravel()).reshape(-1, 3)
        y[~rubs, 1:] = 0.0
        size = np.sqrt(y[:, 1] ** 2 + y[:, 2] ** 2 + width * width)
        direction = y[:, 1:] / size[:, None] * (1.0 + (width / size) ** 2)[:, None]
        y[:, 0] += np.where(rubs, size - width * (width / size), 0.0)
        z = x - y
        low, high, tangent = spectral(z)
        (p_low, c_low), (p_high, c_high) = root(low, width), root(high, width)
        open_ = (x[:, 0] < y[:, 0])[:, None]
        return z, direction, np.where(open_, compose(p_low, p_high, tangent) - x, compose(c_low, c_high, tangent) - y)

    while True:
        steps = 0
        z, direction, miss = missed(x)
        for _ in range(STEPS):
            if float(np.abs(miss).max()) <= 0.1 * width:
                break
            slope, rest = slopes(z, width)
            rows = regular.reshape(k, 3, 3 * k).copy()
            rows[:, 0] += direction[:, 0, None] * rows[:, 1] + direction[:, 1, None] * rows[:, 2]
            matrix = (slope @ rows).reshape(3 * k, 3 * k)
            matrix.reshape(k, 3, k, 3)[each, :, each, :] += rest
            _, _, step, status = gesv(matrix, miss.ravel())
            steps += 1
            if status != 0 or not np.isfinite(step).all():
                return
            way, size, start = np.asarray(step).reshape(-1, 3), 1.0, float((miss * miss).sum())
            way[~rubs, 1:] = 0.0
            for _ in range(8):
                z, direction, miss = missed(x + size * way)
                if float((miss * miss).sum()) < (1.0 - 1e-4 * size) * start:
                    break
                size *= 0.5
            x = x + size * way
        else:
            slow += 1
        yield x, width, steps
        if slow > PATIENCE or width <= narrowest:
            return
        width = max(SHRINK * width, narrowest)


def slopes(z: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
    """The derivative of the smoothed projection at z (k, 3) and one minus it, both (k, 3, 3) and without cancellation."""
    low, high, tangent = spectral(z)
    (p_low, c_low), (p_high, c_high) = root(low, width), root(high, width)
    p, c = np.stack([p_low, p_high, p_low + p_high], axis=1), np.stack([c_low, c_high, c_low + c_high], axis=1)
    frame = frame_of(tangent)
    turned = np.swapaxes(frame, 1, 2)
    return (frame * (p / (p + c))[:, None, :]) @ turned, (frame * (c / (p + c))[:, None, :]) @ turned
