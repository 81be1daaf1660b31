"""Bounds of a probability from a count of hits among trials."""

import math

Z_95 = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def wilson_interval(hits: int, trials: int) -> tuple[float, float]:
    """The 95 % bounds of a binomial probability: (p + z^2/2n -+ z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n), p = hits/n.

    By hand, term by term as SciPy's `binomtest` has it: loading that takes nearly a second, in each process that counts.

    Raises:
        ValueError: for a count that cannot be.

    Source: Wilson, J. Amer. Statist. Assoc. 22 (1927) 209; Newcombe, Statistics in Medicine 17 (1998) 857, method 3.
    """
    if not 0 <= hits <= trials or trials == 0:
        raise ValueError(f"{hits} of {trials}, expected 0 <= hits <= trials and trials > 0")
    share, square = hits / trials, Z_95**2
    whole = 2 * (trials + square)
    middle = (2 * trials * share + square) / whole
    half = Z_95 / whole * math.sqrt(4 * trials * share * (1 - share) + square)
    return 0.0 if hits == 0 else middle - half, 1.0 if hits == trials else middle + half
