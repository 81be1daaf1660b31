"""Bounds of a probability from a count of hits among trials."""

import math

__all__ = ["Z_95", "wilson_interval"]

Z_95 = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def wilson_interval(hits: int, trials: int, z: float = Z_95) -> tuple[float, float]:
    """Bounds of a binomial probability: (p + z^2/2n -+ z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n), p = hits/n.

    Raises:
        ValueError: for a count that cannot be.

    Source: Wilson, J. Amer. Statist. Assoc. 22 (1927) 209.
    """
    if not 0 <= hits <= trials or trials == 0:
        raise ValueError(f"{hits} of {trials}, expected 0 <= hits <= trials and trials > 0")
    share, square = hits / trials, z * z / trials
    half = z * math.sqrt(share * (1 - share) / trials + square / (4 * trials))
    # At the ends one bound is exactly 0 or 1, which rounding would miss.
    low = 0.0 if hits == 0 else (share + square / 2 - half) / (1 + square)
    high = 1.0 if hits == trials else (share + square / 2 + half) / (1 + square)
    return low, high
