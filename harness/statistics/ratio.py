"""One price over another, measured side by side."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Ratio", "ratio"]

DRAWS = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """One price over another, with the 95 % bootstrap interval of the median over blocks."""

    value: float
    low: float
    high: float


def ratio(cost: NDArray[np.float64], base: NDArray[np.float64]) -> Ratio:
    """Median of cost/base over blocks, and the interval of that median.

    Args:
        cost, base: CPU time of a unit in the blocks that both were sampled in, shape (b,), b >= 1, positive.

    Source:
        B. Efron & R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 13 (percentile interval).
    """
    shares = cost / base
    drawn = np.random.default_rng(0).integers(0, len(shares), size=(DRAWS, len(shares)))
    medians = np.median(shares[drawn], axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return Ratio(value=float(np.median(shares)), low=float(low), high=float(high))
