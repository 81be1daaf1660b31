"""De Saxce's correction as a fixed point around convex cone problems, in extended precision.

For given s = mu |u_T| Coulomb's law is the optimality of a convex problem, impulses that minimise 1/2 x W x + q x over a
product of second-order cones, with s added to the normal velocities; the s that its solution returns is fed back, with Anderson
acceleration. Velocities of a convex problem are unique, and it has no turns and no bad starts: it is solved to 1e-13 of the
largest free velocity, which shows who sticks, slips and opens among motions of 1e-9.

*Smoothed Newton.* Optimality is x = p(x - W x - q) with the projection p. Smoothed with a width w it reads x o y = w^2, the
central path, and may be started anywhere. With D the slope of the smoothed projection, Newton's step solves a symmetric
positive definite system,

    (W + D^-1 - 1 + delta) dx = D^-1 (p - x),

where delta, a proximal term, carries the directions in which forces are not unique. The width follows the residual down.

*Precision.* A body held from two sides slips or lifts by 1e-8 m/s where gaps are not closed by the same motion, and who does is
decided by impulses along directions in which W vanishes. W from the engine is positive semi-definite up to round-off only;
there its negative part, 1e-16, would decide. W = G G^T from its positive eigenvalues alone, multiplied out with more digits,
has no such part. In the frames of the contacts the added blocks are diagonal: there their values may spread over all orders of
magnitude and cost no digits, since a Cholesky factorisation does not see the scale of rows.

Source: Acary, Cadoux, Lemarechal, Malick, ZAMM 91, 2011 (fixed point); Walker, Ni, Anderson acceleration for fixed-point
iterations, SIAM J. Numer. Anal. 49, 2011; Fukushima, Luo, Tseng, SIAM J. Optim. 12, 2002, and Chen, Sun, Sun, Comput. Optim.
Appl. 25, 2003 (smoothing); Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, chapter 10.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.cone import inverse_slope, smooth_project
from plumbline.engine.respond.exact.effort import FINE_MATRIX, Effort
from plumbline.engine.respond.exact.law import Scaled

FineArray = NDArray[np.longdouble]

FINE = np.longdouble
"""The widest numbers of the machine: 64 binary digits on x86, 113 or 53 elsewhere, where less is gained."""
VANISHING = 1e-13
"""Eigenvalues below this share of the largest are round-off of W."""
PROXIMAL = 100.0 * float(np.finfo(FINE).eps)
"""Added to the diagonal, in units of a contact's own inverse mass, where forces are not unique."""
DEPTH = 10
"""Earlier iterates that the acceleration looks at."""
WIDEST, NARROWEST, NARROWER = 10.0, 1e-13, 0.3
"""Widths, in units of the largest free velocity, where Newton begins and ends, and from one to the next."""
MOST_STEPS = 80
"""Newton steps allowed."""
PATIENCE = 6
"""Steps without halving the residual at one width: then round-off is reached."""
STEEPEST = 0.1 / float(np.finfo(FINE).eps)
"""Largest inverse slope kept: beyond it a direction does not move."""


def rounds(scaled: Scaled, s: Floats, effort: Effort) -> Iterator[tuple[Floats, Floats]]:
    """Scaled impulses (k, 3) of the convex problems one after the other, and velocities with s on the normal.

    Ends when they are not finite or the effort is over. Args: s (k,): what |u_T| is at first.
    """
    value, vector = np.linalg.eigh(scaled.w)
    real = value > VANISHING * value[-1]
    half = vector[:, real].astype(FINE) * np.sqrt(value[real].astype(FINE))
    w = np.asarray(half @ half.T, FINE)
    tried: list[Floats] = []
    missed: list[Floats] = []
    while True:
        q = scaled.q.astype(FINE)
        q[:, 0] += s
        x = minimise(w, q, scaled.kept, effort)
        if not np.isfinite(x).all():
            return
        y = q + times(w, x)
        yield x.astype(np.float64), y.astype(np.float64)
        if effort.over:
            return
        tried, missed = [*tried, s][-DEPTH - 1 :], [*missed, sliding(scaled.rubs, y) - s][-DEPTH - 1 :]
        s = np.maximum(accelerate(tried, missed), 0.0)


def sliding(rubs: NDArray[np.bool_], y: NDArray[np.floating]) -> Floats:
    """|u_T| (k,) of scaled velocities (k, 3), where friction is one."""
    return np.where(rubs, np.hypot(y[:, 1], y[:, 2]), 0.0).astype(np.float64)


def accelerate(tried: list[Floats], missed: list[Floats]) -> Floats:
    """The next iterate of a fixed point from earlier ones and their residuals (Anderson's type II)."""
    if len(tried) == 1:
        return tried[0] + missed[0]
    dx = np.stack([b - a for a, b in pairwise(tried)], axis=1)
    df = np.stack([b - a for a, b in pairwise(missed)], axis=1)
    gamma = np.linalg.lstsq(df, missed[-1], rcond=1e-10)[0]
    return np.asarray(tried[-1] + missed[-1] - (dx + df) @ gamma)


def times(w: FineArray, x: FineArray) -> FineArray:
    """W x for x (k, 3)."""
    return np.asarray((w @ x.ravel()).reshape(-1, 3))


def minimise(w: FineArray, q: FineArray, kept: NDArray[np.bool_], effort: Effort) -> FineArray:
    """Impulses x (k, 3) of the convex problem.

    Args: w (3k, 3k), q (k, 3): scaled to order one; kept (k, 3): False for components held at zero, where W has zero rows and
        columns; effort: what is left.
    """
    x = np.zeros(q.shape, FINE)
    x[:, 0] = max(1.0, float(np.abs(q).max()))
    y, width, idle, lowest = q + times(w, x), WIDEST, 0, np.inf
    for _ in range(MOST_STEPS):
        z = np.where(kept, x - y, 0.0)
        miss = smooth_project(z, width) - x
        error = float(np.abs(miss).max())
        if error <= max(0.1 * width, NARROWEST):
            if width <= NARROWEST:
                return x
            width, idle, lowest = max(NARROWER * width, NARROWEST), 0, np.inf
            miss = smooth_project(z, width) - x
        elif error > 0.5 * lowest:
            idle += 1
            if idle > PATIENCE:
                return x
        lowest = min(error, lowest)
        step = newton_step(w, *inverse_slope(z, width), miss) if effort.take(FINE_MATRIX) else None
        if step is None:
            return x
        step[~kept] = 0.0
        change, size, start = times(w, step), 1.0, float((miss * miss).sum())
        for _ in range(12):
            nx, ny = x + size * step, y + size * change
            miss = smooth_project(np.where(kept, nx - ny, 0.0), width) - nx
            if float((miss * miss).sum()) <= (1.0 - 1e-4 * size) * start:
                break
            size *= 0.5
        else:
            return x
        x, y = nx, q + times(w, nx)
    return x


def newton_step(w: FineArray, values: FineArray, frame: FineArray, miss: FineArray) -> FineArray | None:
    """(W + D^-1 - 1 + delta)^-1 D^-1 miss, D^-1 with eigenvalues (k, 3) on frames (k, 3, 3); None where it is not definite."""
    k, n, values = len(miss), len(w), np.minimum(values, STEEPEST)
    turned, each = np.swapaxes(frame, 1, 2), np.arange(n)
    half = (turned @ w.reshape(k, 3, n)).reshape(n, n).T
    matrix = (turned @ half.reshape(k, 3, n)).reshape(n, n)
    right = (values[:, :, None] * (turned @ miss[:, :, None])).ravel()
    for proximal in PROXIMAL * 10.0 ** np.arange(8):
        tried = matrix.copy()
        tried[each, each] += (values - 1.0).ravel() + proximal
        if cholesky(tried):
            return np.asarray((frame @ solve_factored(tried, right).reshape(k, 3, 1))[:, :, 0])
    return None


def cholesky(a: FineArray) -> bool:
    """Overwrite the lower triangle of a (n, n) by its factor. Returns: whether a is positive definite."""
    for j in range(len(a)):
        a[j:, j] -= a[j:, :j] @ a[j, :j]
        if not a[j, j] > 0.0:
            return False
        a[j:, j] /= np.sqrt(a[j, j])
    return True


def solve_factored(lower: FineArray, x: FineArray) -> FineArray:
    """Overwrite the right side x (n,) by the solution, by a factor of `cholesky`."""
    for j in range(len(x)):
        x[j] = (x[j] - lower[j, :j] @ x[:j]) / lower[j, j]
    for j in range(len(x) - 1, -1, -1):
        x[j] = (x[j] - lower[j + 1 :, j] @ x[j + 1 :]) / lower[j, j]
    return x
