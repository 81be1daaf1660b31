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
def product(a: Floats, i: int, b: Floats, j: int) -> float:
    """Row i of a times row j of b."""
    total = 0.0
    for c in range(a.shape[1]):
        total += a[i, c] * b[j, c]
    return total


@kernel
def take_away(a: Floats, i: int, share: float, b: Floats, j: int) -> None:
    """Take a share of row j of b from row i of a."""
    for c in range(a.shape[1]):
        a[i, c] -= share * b[j, c]


@kernel
def mix(guess: Floats, step: Floats, dx: Floats, df: Floats, kept: int) -> None:
    """Write the next guess into row `DEPTH` of dx.

    Args: guess, step: x and f of the last rounds, a row each, newest first; dx, df: room for `DEPTH` differences, and one row;
        kept: rows that are known.
    """
    for c in range(guess.shape[1]):
        df[DEPTH, c], dx[DEPTH, c] = step[0, c], guess[0, c] + step[0, c]
    for j in range(kept - 1):
        for c in range(guess.shape[1]):
            dx[j, c], df[j, c] = guess[j, c] - guess[j + 1, c], step[j, c] - step[j + 1, c]
        before = product(df, j, df, j)
        for i in range(j):
            size = product(df, i, df, i)
            share = product(df, i, df, j) / size if size > 0.0 else 0.0
            take_away(df, j, share, df, i)
            take_away(dx, j, share, dx, i)
        size = product(df, j, df, j)
        if size > ALIKE * ALIKE * before and math.isfinite(size):
            share = product(df, j, df, DEPTH) / size
            take_away(df, DEPTH, share, df, j)
            take_away(dx, DEPTH, share, dx, j)
            take_away(dx, DEPTH, share, df, j)
        else:
            for c in range(guess.shape[1]):
                dx[j, c], df[j, c] = 0.0, 0.0
