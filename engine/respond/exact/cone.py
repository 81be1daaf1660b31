"""The second-order cone |x_T| <= x_N as a Jordan algebra: spectral values, projections, slope.

A vector x = (x_N, x_T) has the spectral values x_N -+ |x_T| on the frame (1, -+t)/2, t = x_T / |x_T|. A function of one number
acts on a vector through its spectral values.

Source: Fukushima, Luo, Tseng, Smoothing functions for second-order-cone complementarity problems, SIAM J. Optim. 12, 2002.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[Any]
"""Real numbers of any precision; what is returned has the precision of the arguments."""


def spectral(x: Reals) -> tuple[Reals, Reals, Reals]:
    """Lower and upper spectral value (k,) and tangent direction (k, 2) of vectors (k, 3)."""
    size = np.hypot(x[:, 1], x[:, 2])
    tangent = np.where(size[:, None] > 0.0, x[:, 1:] / np.maximum(size, 1e-300)[:, None], (1.0, 0.0))
    return x[:, 0] - size, x[:, 0] + size, tangent


def compose(low: Reals, high: Reals, tangent: Reals) -> Reals:
    """The vectors (k, 3) with these spectral values on this frame."""
    half = 0.5 * (high - low)
    return np.stack([0.5 * (low + high), half * tangent[:, 0], half * tangent[:, 1]], axis=1)


def root(value: Reals, width: float) -> tuple[Reals, Reals]:
    """p = (z + sqrt(z^2 + 4 w^2)) / 2, without cancellation, and its conjugate p - z, whose product is w^2."""
    length = 0.5 * (np.abs(value) + np.sqrt(value * value + 4.0 * width * width))
    other = width * width / np.maximum(length, 1e-300)
    return np.where(value >= 0.0, length, other), np.where(value >= 0.0, other, length)


def smooth_project(z: Reals, width: float) -> Reals:
    """The smoothed projection of vectors (k, 3): x of the pair x o y = width^2, x - y = z, inside the cone."""
    low, high, tangent = spectral(z)
    return compose(root(low, width)[0], root(high, width)[0], tangent)


def inverse_slope(z: Reals, width: float) -> tuple[Reals, Reals]:
    """The derivative of the smoothed projection at z, as its inverse eigenvalues (k, 3) and its orthonormal frame (k, 3, 3).

    With p the smoothed projection and c = p - z its conjugate, p c = w^2, the inverse eigenvalue is (p + c) / p on either end
    of the frame, and across it (h - l) / (p(h) - p(l)) = 1 + (c(l) + c(h)) / (p(l) + p(h)): no form here cancels. The frame is
    kept apart because its eigenvalues spread over all orders of magnitude.
    """
    low, high, tangent = spectral(z)
    p_low, c_low = root(low, width)
    p_high, c_high = root(high, width)
    values = np.stack([1.0 + c_low / p_low, 1.0 + c_high / p_high, 1.0 + (c_low + c_high) / (p_low + p_high)], axis=1)
    return values, frame_of(tangent)


def frame_of(tangent: Reals) -> Reals:
    """Orthonormal frames (k, 3, 3) with the columns (1, -t) / sqrt 2, (1, t) / sqrt 2 and across, for unit tangents (k, 2)."""
    frame, half = np.zeros((len(tangent), 3, 3), tangent.dtype), np.sqrt(tangent.dtype.type(0.5))
    frame[:, 0, :2] = half
    frame[:, 1:, 0], frame[:, 1:, 1] = -half * tangent, half * tangent
    frame[:, 1, 2], frame[:, 2, 2] = -tangent[:, 1], tangent[:, 0]
    return frame
