"""The percentile bootstrap: how a statistic is spread over samples drawn again from those that were taken.

Source: B. Efron & R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 13 (percentile interval).
"""

import numpy as np
from numpy.typing import NDArray

__all__ = ["interval_of_drawn", "interval_of_median", "medians"]

DRAWS = 2000
ENDS = (2.5, 97.5)
"""Percentiles of an interval of 95 %."""


def interval_of_drawn(values: NDArray[np.float64]) -> tuple[float, float]:
    """The 95 % interval of a statistic from its drawn values, shape (d,), d >= 1, finite."""
    low, high = np.percentile(values, ENDS)
    return float(low), float(high)


def interval_of_median(values: NDArray[np.float64]) -> tuple[float, float]:
    """The 95 % interval of the median of values, shape (n,), n >= 1: the same for the same values."""
    drawn = np.random.default_rng(0).integers(0, len(values), size=(DRAWS, len(values)))
    return interval_of_drawn(np.median(values[drawn], axis=1))


def medians(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The median of the numbers in each row, nan where a row has none: shape (n, m) to (n,)."""
    ordered = np.sort(values, axis=1)  # nan last
    count, rows = np.isfinite(values).sum(axis=1), np.arange(len(values))
    lower, upper = ordered[rows, np.maximum(count - 1, 0) // 2], ordered[rows, np.minimum(count // 2, values.shape[1] - 1)]
    middle: NDArray[np.float64] = 0.5 * (lower + upper)
    return middle
