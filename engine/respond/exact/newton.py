"""Smoothed Newton on the convex cone problem: impulses that minimise 1/2 x W x + q x over a product of second-order cones.

Optimality is x = p(x - W x - q) with the projection p. Smoothed with a width w it reads x o y = w^2, the central path, but may
be started anywhere. With D the slope of the smoothed projection, Newton's step solves a symmetric positive definite system,

    (W + D^-1 - 1 + delta) dx = D^-1 (p - x),

where delta, a proximal term, carries the directions in which forces are not unique. The width follows the residual down.

Source: Fukushima, Luo, Tseng, SIAM J. Optim. 12, 2002; Chen, Sun, Sun, Comput. Optim. Appl. 25, 2003.
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.respond.exact.blocks import FINE, Blocks, FineArray
from plumbline.engine.respond.exact.cone import inverse_slope, smooth_project
from plumbline.engine.respond.exact.effort import FINE_MATRIX, Effort

NARROWER = 0.3
"""From one width to the next."""
MOST_STEPS = 80
"""Newton steps allowed."""
PATIENCE = 6
"""Steps without halving the residual at one width: then round-off is reached."""
STEEPEST = 0.1 / float(np.finfo(FINE).eps)
"""Largest inverse slope kept: beyond it a direction does not move."""


def minimise(
    blocks: Blocks, q: FineArray, kept: NDArray[np.bool_], x: FineArray, width: float, goal: float, effort: Effort
) -> FineArray:
    """Impulses x (k, 3) of the convex problem.

    Args: blocks: W (3k, 3k), with q (k, 3) scaled to order one; kept (k, 3): False for components held at zero, where W
        has zero rows and columns; x: where to start; width: of
        the smoothing at the start; goal: residual to reach; effort: what is left.
    Returns: impulses.
    """
    y = q + blocks.times(x)
    idle, lowest = 0, np.inf
    for _ in range(MOST_STEPS):
        z = np.where(kept, x - y, 0.0)
        miss = smooth_project(z, width) - x
        error = float(np.abs(miss).max())
        if error <= max(0.1 * width, goal):
            if width <= goal:
                return x
            width, idle, lowest = max(NARROWER * width, goal), 0, np.inf
            miss = smooth_project(z, width) - x
        elif error > 0.5 * lowest:
            idle += 1
            if idle > PATIENCE:
                return x
        lowest = min(error, lowest)
        values, frame = inverse_slope(z, width)
        values = np.minimum(values, STEEPEST)
        if not (effort.take(FINE_MATRIX) and blocks.factor(frame, np.asarray(values - 1.0, FINE))):
            return x
        step = blocks.solve((frame @ (values[:, :, None] * (np.swapaxes(frame, 1, 2) @ miss[:, :, None])))[:, :, 0])
        step[~kept] = 0.0
        change = blocks.times(step)
        size, start = 1.0, float((miss * miss).sum())
        for _ in range(12):
            nx, ny = x + size * step, y + size * change
            miss = smooth_project(np.where(kept, nx - ny, 0.0), width) - nx
            if float((miss * miss).sum()) <= (1.0 - 1e-4 * size) * start:
                break
            size *= 0.5
        else:
            return x
        x, y = nx, q + blocks.times(nx)
    return x
