"""A value with its interval, and the percentile bootstrap: how a statistic is spread over samples drawn again from those that
were taken.

Sources: B. Efron & R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 13 (percentile interval); A. C. Davison &
D. V. Hinkley, Bootstrap Methods and their Application (1997), section 3.8 (samples that come in groups); T. C. Hesterberg, What
Teachers Should Know About the Bootstrap, The American Statistician 69 (2015) 371, section 4.4 (few samples).
"""

import math
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.student import Z_95, percentile

DRAWS = 2000
ENDS = (2.5, 97.5)
"""Percentiles of an interval of 95 %."""


def interval_of_drawn(values: NDArray[np.float64]) -> tuple[float, float]:
    """The 95 % interval of a statistic from its drawn values, shape (d,), d >= 1, finite."""
    low, high = np.percentile(values, ENDS)
    return float(low), float(high)


def widening(count: int) -> float:
    """By how much the bootstrap's interval of so many samples is to be wider: it takes their spread for the true one.

    Student's t over the normal's percentile: 2.19 for three samples, 1.4 for five, 1.05 for thirty. 1 for one, whose spread
    nobody knows.
    """
    return percentile(ENDS[1] / 100, count - 1) / Z_95 if count > 1 else 1.0


def interval_of_median(values: NDArray[np.float64], groups: Sequence[int] | None = None) -> tuple[float, float]:
    """The 95 % interval of the median of positive values, shape (n,), n >= 1: the same for the same values, and positive.

    Args: groups: of each value, whose members have more in common than their median says: groups are drawn first, then values
    within each. One group without it.
    """
    numbers = [0] * len(values) if groups is None else groups
    order = np.argsort(numbers, kind="stable")
    places = drawn_in_groups(tuple(Counter(np.asarray(numbers)[order].tolist()).values()), DRAWS)
    low, high = interval_of_drawn(medians(np.append(values[order], np.nan)[places]))
    middle, wider = float(np.median(values)), widening(len(values))
    return middle * (low / middle) ** wider, middle * (high / middle) ** wider


def with_drift(middle: float, interval: tuple[float, float], drift: float) -> tuple[float, float]:
    """A 95 % interval of what is measured at one time, so wide that it holds at another: independent spreads add up in squares.

    Args: drift: of what is measured from one time to another, root mean square and relative.
    """
    low, high = (math.exp(math.hypot(math.log(end / middle), Z_95 * drift)) for end in interval)
    return middle / low, middle * high


@lru_cache(maxsize=64)
def drawn_in_groups(counts: tuple[int, ...], draws: int) -> NDArray[np.int64]:
    """Which samples each draw takes, shape (draws, m), of groups of so many that stand one after the other.

    Groups may have different numbers of samples: shorter draws end in the place behind the last sample.
    """
    rng = np.random.default_rng(0)
    members = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
    if len(counts) == 1:
        return rng.integers(0, counts[0], size=(draws, counts[0]))

    def drawn_from(count: int) -> NDArray[np.int64]:
        return rng.integers(0, count, size=count)

    chosen = [np.concatenate([members[g][drawn_from(counts[g])] for g in drawn_from(len(counts))]) for _ in range(draws)]
    places = np.full((draws, max(map(len, chosen))), sum(counts), dtype=np.int64)
    for draw, taken in enumerate(chosen):
        places[draw, : len(taken)] = taken
    return places


def medians(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The median of the numbers in each row, nan where a row has none: shape (n, m) to (n,)."""
    ordered = np.sort(values, axis=1)  # nan last
    count, rows = np.isfinite(values).sum(axis=1), np.arange(len(values))
    lower, upper = ordered[rows, np.maximum(count - 1, 0) // 2], ordered[rows, np.minimum(count // 2, values.shape[1] - 1)]
    middle: NDArray[np.float64] = 0.5 * (lower + upper)
    return middle


def ratio(cost: NDArray[np.float64], base: NDArray[np.float64], processes: Sequence[int] | None = None) -> Interval:
    """Median of cost/base over blocks, and the interval of that median.

    Args:
        cost, base: CPU time of a unit in the blocks that both were sampled in, shape (b,), b >= 1, positive. processes: the
        process of each block, whose blocks are drawn together; None for one.
    """
    shares = cost / base
    return Interval(float(np.median(shares)), *interval_of_median(shares, processes))
