"""The convex cone problem, impulses that minimise 1/2 x W x + q x over a product of second-order cones, in two ways.

*Interior-point steps* lead from the middle of the cones towards the solution, whatever the start. In the Nesterov-Todd scaling
T y = T^-1 x = lambda of each cone the central path x o y = mu is followed by

    (W + T^-2) dx = T^-1 lambda \\ (sigma mu - lambda o lambda - correction) - (W x + q - y),

a predictor (sigma = 0) and a corrector per round on one factorisation.

*Smoothed Newton* ends it. Optimality is x = p(x - W x - q) with the projection p. Smoothed with a width w it reads x o y = w^2,
the central path, but may be started anywhere. With D the slope of the smoothed projection, Newton's step solves a symmetric
positive definite system,

    (W + D^-1 - 1 + delta) dx = D^-1 (p - x),

where delta, a proximal term, carries the directions in which forces are not unique. The width follows the residual down.

Source: Nesterov, Todd, Math. Oper. Res. 22, 1997; Mehrotra, SIAM J. Optim. 2, 1992; Vandenberghe, The CVXOPT linear and
quadratic cone program solvers, 2010 (sections 4 and 7); Acary, Armand, Nguyen, Shpakovych, Second-order cone programming for
frictional contact mechanics using interior point algorithm, Optim. Methods Softw., 2024; Fukushima, Luo, Tseng, SIAM J. Optim.
12, 2002; Chen, Sun, Sun, Comput. Optim. Appl. 25, 2003 (smoothing).
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.respond.exact.blocks import FINE, Blocks, FineArray
from plumbline.engine.respond.exact.cone import frame_of, inverse_slope, smooth_project
from plumbline.engine.respond.exact.effort import FINE_MATRIX, Effort

CLOSE = 0.99
"""Share of the way to the boundary of the cones that a step may take."""


def product(a: FineArray, b: FineArray) -> FineArray:
    """The Jordan product (a . b, a_N b_T + b_N a_T) of vectors (k, 3)."""
    out = a[:, :1] * b + b[:, :1] * a
    out[:, 0] = (a * b).sum(axis=1)
    return out


def quotient(a: FineArray, b: FineArray) -> FineArray:
    """The x (k, 3) with a o x = b, a inside the cone."""
    size = np.hypot(a[:, 1], a[:, 2])
    det = (a[:, 0] - size) * (a[:, 0] + size)
    along = a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    first = (a[:, 0] * b[:, 0] - along) / det
    out = (b - first[:, None] * a) / a[:, :1]
    out[:, 0] = first
    return np.asarray(out)


def longest(x: FineArray, dx: FineArray) -> float:
    """The largest t <= 1 / CLOSE with x + t dx in the cones."""
    a = dx[:, 0] ** 2 - dx[:, 1] ** 2 - dx[:, 2] ** 2
    b = x[:, 0] * dx[:, 0] - x[:, 1] * dx[:, 1] - x[:, 2] * dx[:, 2]
    size = np.hypot(x[:, 1], x[:, 2])
    c = np.maximum((x[:, 0] - size) * (x[:, 0] + size), 1e-300)
    # The first positive root of a t^2 + 2 b t + c; in the form c / (-b + sqrt) nothing cancels.
    inside = b * b - a * c
    under = -b + np.sqrt(np.maximum(inside, 0.0))
    hits = (inside >= 0.0) & (under > 0.0)
    return min(1.0 / CLOSE, float((c[hits] / under[hits]).min(initial=np.inf)))


def central_point(blocks: Blocks, q: FineArray, goal: float, most: int, effort: Effort) -> tuple[FineArray, float]:
    """Impulses x (k, 3) near the central path.

    Args: blocks: W (3k, 3k) scaled to order one; q (k, 3); goal: mean of sqrt(x . y) to reach; most: rounds allowed;
        effort: what is left.
    Returns: x, the mean reached.
    """
    k = len(q)
    start = max(1.0, float(np.abs(q).max()))
    x, y = np.zeros((k, 3), FINE), np.zeros((k, 3), FINE)
    x[:, 0] = y[:, 0] = start
    mean = start * start
    for _ in range(most):
        mean = float((x * y).sum()) / k
        miss = blocks.times(x) + q - y
        if mean <= goal * goal and float(np.abs(miss).max()) <= goal:
            return x, goal
        frame, stretch = scaling(x, y)
        turned = np.swapaxes(frame, 1, 2)
        scaled = turn(frame, stretch * turn(turned, y))
        if not (effort.take(FINE_MATRIX) and blocks.factor(frame, 1.0 / stretch**2)):
            return x, float(np.sqrt(mean))
        square = product(scaled, scaled)
        rest, share = -square, 0.0
        for stage in range(2):
            d = quotient(scaled, rest)
            right = turn(frame, turn(turned, d) / stretch) - miss
            dx = blocks.solve(right)
            dx_scaled = turn(frame, turn(turned, dx) / stretch)
            dy_scaled = d - dx_scaled
            dy = turn(frame, turn(turned, dy_scaled) / stretch)
            way = min(1.0, CLOSE * min(longest(x, dx), longest(y, dy)))
            if stage == 0:
                share = (1.0 - way) ** 3
                rest = -square - product(dx_scaled, dy_scaled)
                rest[:, 0] += share * mean
        if not (np.isfinite(dx).all() and np.isfinite(dy).all()):
            return x, float(np.sqrt(mean))
        x, y = x + way * dx, y + way * dy
    return x, float(np.sqrt(mean))


def turn(frame: FineArray, v: FineArray) -> FineArray:
    """frame (k, 3, 3) times v (k, 3)."""
    return np.asarray((frame @ v[:, :, None])[:, :, 0])


def scaling(x: FineArray, y: FineArray) -> tuple[FineArray, FineArray]:
    """The frame (k, 3, 3) and the eigenvalues (k, 3) of the Nesterov-Todd scaling T with T y = T^-1 x."""
    sx, sy = np.hypot(x[:, 1], x[:, 2]), np.hypot(y[:, 1], y[:, 2])
    dx = np.sqrt(np.maximum((x[:, 0] - sx) * (x[:, 0] + sx), 1e-300))
    dy = np.sqrt(np.maximum((y[:, 0] - sy) * (y[:, 0] + sy), 1e-300))
    a, b = x / dx[:, None], y / dy[:, None]
    b[:, 1:] *= -1.0
    half = np.sqrt(0.5 * (1.0 + a[:, 0] * b[:, 0] - a[:, 1] * b[:, 1] - a[:, 2] * b[:, 2]))
    middle = (a + b) / (2.0 * half)[:, None]
    size = np.hypot(middle[:, 1], middle[:, 2])
    tangent = np.where(size[:, None] > 0.0, middle[:, 1:] / np.maximum(size, 1e-300)[:, None], (1.0, 0.0))
    up = np.sqrt(1.0 + size * size) + size
    eta = np.sqrt(dx / dy)
    return frame_of(tangent), eta[:, None] * np.stack([1.0 / up, up, np.ones_like(up)], axis=1)


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
