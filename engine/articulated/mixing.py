"""Anderson's mixing: the next guess of an iteration x <- x + f(x) that converges slowly, or not at all, by its last few ones.

    gamma = argmin norm(f - dF gamma),    x <- x + f - (dX + dF) gamma

dX and dF hold the differences of the last guesses and of their steps, newest first. For a linear f of n unknowns it ends after
n + 1 rounds whatever its slope, as GMRES does.

Source: Anderson, Iterative procedures for nonlinear integral equations, J. ACM 12(4), 1965; Walker, Ni, Anderson acceleration
for fixed-point iterations, SIAM J. Numer. Anal. 49(4), 2011.
"""

import math
from typing import Final

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats

DEPTH: Final = 6
"""Differences that are kept at most."""

ALIKE: Final = 1e-10
"""Share of a difference [1] that has to be new against the others for it to count: below, the least squares are noise."""


@kernel
def reduced(dx: Floats, df: Floats, j: int) -> bool:
    """Take from difference j of the steps what it has of those before it, and the same of the guesses. Returns: is any left?"""
    before, after = 0.0, 0.0
    for c in range(df.shape[1]):
        before += df[j, c] * df[j, c]
    for i in range(j):
        along, size = 0.0, 0.0
        for c in range(df.shape[1]):
            along, size = along + df[i, c] * df[j, c], size + df[i, c] * df[i, c]
        if size > 0.0:
            for c in range(df.shape[1]):
                df[j, c] -= along / size * df[i, c]
                dx[j, c] -= along / size * dx[i, c]
    for c in range(df.shape[1]):
        after += df[j, c] * df[j, c]
    return after > ALIKE * ALIKE * before and math.isfinite(after)


@kernel
def mixed(guess: Floats, step: Floats, work_x: Floats, work_f: Floats, kept: int, answer: Floats) -> None:
    """Write the next guess.

    Args: guess, step: x and f of the last rounds, a row each, newest first; work_x, work_f: room for `DEPTH` differences;
        kept: rows that are known; answer: (n,), x and then the next x.
    """
    n = answer.shape[0]
    for c in range(n):
        work_f[DEPTH, c] = step[0, c]
        answer[c] = guess[0, c] + step[0, c]
    for j in range(kept - 1):
        for c in range(n):
            work_x[j, c], work_f[j, c] = guess[j, c] - guess[j + 1, c], step[j, c] - step[j + 1, c]
        if not reduced(work_x, work_f, j):
            for c in range(n):
                work_x[j, c], work_f[j, c] = 0.0, 0.0
            continue
        along, size = 0.0, 0.0
        for c in range(n):
            along, size = along + work_f[j, c] * work_f[DEPTH, c], size + work_f[j, c] * work_f[j, c]
        for c in range(n):
            work_f[DEPTH, c] -= along / size * work_f[j, c]
            answer[c] -= along / size * (work_x[j, c] + work_f[j, c])
