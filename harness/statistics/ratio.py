"""One price over another, measured side by side."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.bootstrap import interval_of_median
from plumbline.harness.statistics.interval import Interval


def ratio(cost: NDArray[np.float64], base: NDArray[np.float64], processes: Sequence[int] | None = None) -> Interval:
    """Median of cost/base over blocks, and the interval of that median.

    Args:
        cost, base: CPU time of a unit in the blocks that both were sampled in, shape (b,), b >= 1, positive. processes: the
        process of each block, whose blocks are drawn together; None for one.
    """
    shares = cost / base
    return Interval(float(np.median(shares)), *interval_of_median(shares, processes))
