"""Path tracing on Coulomb's law by arc length, around the turns where following by width alone has to stop.

Where sliding feeds back into the normal velocities a path may turn: no solution near by exists for a smaller width; the path
goes back to larger ones before it comes down again. Traced by its arc length in (x, log w) it passes such turns. The smoothing

    y = (W + w^2) x + q + (|y_T|^2 / sqrt(|y_T|^2 + w^2), 0, 0),    F = p(x - y) - x = 0

makes a convex problem of large widths, which has one solution, so that the path from there leads down; it shifts a sticking
contact by nothing and a sliding one by w^2, so that a jammed body is not loosened by it.

Source: Allgower, Georg, Introduction to Numerical Continuation Methods, SIAM 2003, chapters 2 and 6; Fukushima, Luo, Tseng,
SIAM J. Optim. 12, 2002 (smoothing).
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from engine.exact.cone import compose, inverse_slope, root, smooth_project, spectral

__all__ = ["trace_path"]

FloatArray = NDArray[np.float64]

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

WIDEST, NARROWEST = 10.0, 1e-13
"""Widths, in units of the largest free velocity, where the path starts and ends."""
PROXIMAL = 1e-15
"""Added to the diagonal for the steps alone."""
CENTRED = 0.3
"""How far, relative to its distance from the boundary of the cone, a contact may be off the path."""
SHORTEST = 1e-7
"""Arc length of a step below which the path is given up."""


class _Path:
    """F and its derivatives for one problem: w (3k, 3k) and q (k, 3) scaled to order one and mu = 1, rubs (k,)."""

    def __init__(self, w: FloatArray, q: FloatArray, rubs: NDArray[np.bool_]) -> None:
        self.w, self.q, self.rubs = w, q, rubs
        self.one = np.eye(len(w))

    def at(self, x: FloatArray, width: float) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """F (k, 3), -dF/dx (3k, 3k), dF/dw (k, 3), and how far x is off the path relative to its room."""
        k, soft, square = len(x), width * width, width * width
        y = self.q + (self.w @ x.ravel()).reshape(-1, 3) + soft * x
        y[~self.rubs, 1:] = 0.0
        size = np.sqrt(y[:, 1] ** 2 + y[:, 2] ** 2 + square)
        lift = y[:, 1:] / size[:, None] * (1.0 + square / size**2)[:, None]
        y[:, 0] += np.where(self.rubs, size - square / size, 0.0)
        z = x - y
        miss = smooth_project(z, width) - x
        values, frame = inverse_slope(z, width)
        slope = (frame / values[:, None, :]) @ np.swapaxes(frame, 1, 2)
        rows = (self.w + (soft + PROXIMAL) * self.one).reshape(k, 3, 3 * k)
        rows[:, 0] += lift[:, 0, None] * rows[:, 1] + lift[:, 1, None] * rows[:, 2]
        matrix = self.one - (slope @ (self.one.reshape(k, 3, 3 * k) - rows)).reshape(3 * k, 3 * k)
        low, high, tangent = spectral(z)
        rate = compose(2.0 * width / np.hypot(low, 2.0 * width), 2.0 * width / np.hypot(high, 2.0 * width), tangent)
        pushed = 2.0 * width * x
        sliding = (lift * pushed[:, 1:]).sum(axis=1) - (size**2 - square) * width / size**3
        pushed[:, 0] += np.where(self.rubs, sliding, 0.0)
        rate -= (slope @ pushed[:, :, None])[:, :, 0]
        return miss, matrix, rate, off_centre(z, miss, width)


def off_centre(z: FloatArray, miss: FloatArray, width: float) -> float:
    """The largest spectral value of the miss relative to the room that its contact has within the cone and its dual."""
    low, high, tangent = spectral(z)
    (p_low, c_low), (p_high, c_high) = root(low, width), root(high, width)
    along = miss[:, 1] * tangent[:, 0] + miss[:, 2] * tangent[:, 1]
    across = miss[:, 2] * tangent[:, 0] - miss[:, 1] * tangent[:, 1]
    round_off = 1e-14 + 3e-15 * float(np.abs(z).max())
    shares = (
        (miss[:, 0] - along) / (np.minimum(p_low, c_low) + round_off),
        (miss[:, 0] + along) / (np.minimum(p_high, c_high) + round_off),
        across / (np.minimum(p_low + p_high, c_low + c_high) + round_off),
    )
    return float(np.abs(shares).max())


def trace_path(w: FloatArray, q: FloatArray, rubs: NDArray[np.bool_], most: int) -> Iterator[tuple[FloatArray, float, int]]:
    """Points of the path, each with its width and the matrices factorised since the last one; ends where the path is lost.

    Args: w (3k, 3k), q (k, 3), rubs (k,): as `follow_path`; most: matrices allowed.
    """
    path, n = _Path(w, q, rubs), len(w)
    x, used = start(path)
    log_width, arc = math.log(WIDEST), 1.0
    # Unknowns are dx / w and the change of log w, so that a step means the same at every width.
    turn = np.zeros(n + 1)
    turn[n] = -1.0
    matrix, right = np.empty((n + 1, n + 1)), np.zeros(n + 1)

    def bordered(slope: FloatArray, rate: FloatArray) -> None:
        matrix[:n, :n], matrix[:n, n] = slope, -rate.ravel()
        matrix[n, :n], matrix[n, n] = turn[:n] / n, turn[n]

    count = used
    while used < most:
        width = math.exp(log_width)
        _, slope, rate, _ = path.at(x, width)
        bordered(slope, rate)
        right[:n], right[n] = 0.0, 1.0
        _, _, made, status = gesv(matrix, right)
        used += 1
        if status != 0 or not np.isfinite(made).all():
            return
        turn = made / math.sqrt(made[:n] @ made[:n] / n + made[n] ** 2)
        while arc > SHORTEST:
            step = min(arc, 1.5 / max(abs(turn[n]), 1e-9))
            grown = math.expm1(step * turn[n]) / turn[n] if abs(turn[n]) > 1e-8 else step
            found, log_found, tries = x + width * grown * turn[:n].reshape(-1, 3), log_width + step * turn[n], 0
            last, done = math.inf, False
            while tries < 8:
                near = math.exp(log_found)
                miss, slope, rate, off = path.at(found, near)
                done = off <= CENTRED
                if done or not math.isfinite(off) or (tries > 1 and off > 2.0 * last):
                    break
                last = off
                bordered(slope, rate)
                right[:n], right[n] = miss.ravel() / near, 0.0
                _, _, made, status = gesv(matrix, right)
                used, tries = used + 1, tries + 1
                if status != 0 or not np.isfinite(made).all() or abs(made[n]) > 3.0:
                    break
                way = made[:n].reshape(-1, 3)
                way[~rubs, 1:] = 0.0
                found, log_found = found + near * way, log_found + float(made[n])
            if done:
                break
            arc *= 0.35
        else:
            return
        x, log_width = found, log_found
        arc *= (2.0, 2.0, 2.0, 1.3, 1.3, 1.0, 0.7, 0.7, 0.7)[tries]
        yield x, math.exp(log_width), used - count
        count = used
        if not math.log(NARROWEST) < log_width < math.log(10.0 * WIDEST):
            return


def start(path: _Path) -> tuple[FloatArray, int]:
    """The point of the path (k, 3) at the widest width by Newton with a line search, and the matrices factorised."""
    x = np.zeros_like(path.q)
    x[:, 0] = WIDEST
    miss, slope, _, off = path.at(x, WIDEST)
    for count in range(60):
        if off < 1e-2:
            return x, count
        _, _, way, _ = gesv(slope, miss.ravel())
        way, size, before = way.reshape(-1, 3), 1.0, float((miss * miss).sum())
        way[~path.rubs, 1:] = 0.0
        for _ in range(10):
            miss, slope, _, off = path.at(x + size * way, WIDEST)
            if float((miss * miss).sum()) < (1.0 - 1e-4 * size) * before:
                break
            size *= 0.5
        x = x + size * way
    return x, 60
