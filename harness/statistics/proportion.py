"""Bounds of a probability from a count of hits among trials."""

__all__ = ["Z_95", "wilson_interval"]

Z_95 = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def wilson_interval(hits: int, trials: int) -> tuple[float, float]:
    """The 95 % bounds of a binomial probability: (p + z^2/2n -+ z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n), p = hits/n.

    Raises:
        ValueError: for a count that cannot be.

    Source: Wilson, J. Amer. Statist. Assoc. 22 (1927) 209.
    """
    from scipy.stats import binomtest  # late: half a second that only counts need

    if not 0 <= hits <= trials or trials == 0:
        raise ValueError(f"{hits} of {trials}, expected 0 <= hits <= trials and trials > 0")
    bounds = binomtest(hits, trials).proportion_ci(0.95, method="wilson")
    return float(bounds.low), float(bounds.high)
