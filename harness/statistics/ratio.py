"""One price over another, measured side by side."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.bootstrap import interval_of_median


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """One price over another, with the 95 % bootstrap interval of the median over blocks."""

    value: float
    low: float
    high: float


def ratio(cost: NDArray[np.float64], base: NDArray[np.float64], processes: Sequence[int] | None = None) -> Ratio:
    """Median of cost/base over blocks, and the interval of that median.

    Args:
        cost, base: CPU time of a unit in the blocks that both were sampled in, shape (b,), b >= 1, positive. processes: the
        process of each block, whose blocks are drawn together; None for one.
    """
    shares = cost / base
    low, high = interval_of_median(shares, processes)
    return Ratio(value=float(np.median(shares)), low=low, high=high)
