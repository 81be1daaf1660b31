"""Two steps the same way, or one slope that is still under way when the first of them is seen?"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.change_points import FEWEST, without_outliers

Floats: TypeAlias = NDArray[np.float64]

MARGIN = 6.0
"""Squared spreads by which two steps have to fit better than a slope: exp(-6/2) is a chance of one in twenty."""
SHORTEST = 2 * FEWEST + 2
"""Nights that have a spread."""
ENDS = 150
"""Nights on which a slope may begin and end: of more of them, every second, third, ..."""


def one_drift(series: Floats, first: int, second: int) -> bool:
    """Does one slope between two levels fit a series (n,), positive, NaN for a night without a value, as well as two steps?

    Least squares of logarithms whose outliers are clipped. The slope may begin and end on any night; between its ends r(t)
    grows from 0 to 1, and log p(t) = (1 - r(t)) p_0 + r(t) p_1.

    Args: first, second: indices of the nights on which the two steps lie.
    """
    nights = np.flatnonzero(np.isfinite(series) & (series > 0))
    if len(nights) < SHORTEST or first >= second:
        return False
    y, spread = without_outliers(np.log(series[nights]))
    parts = np.split(y, np.searchsorted(nights, [first, second]))
    stairs = sum(float(((part - part.mean()) ** 2).sum()) for part in parts if len(part))
    return _of_slope(y, nights) <= stairs + MARGIN * spread**2


def _of_slope(y: Floats, nights: NDArray[np.int64]) -> float:
    """The least sum of squares around a slope that lasts three nights or more."""
    tried = np.arange(0, len(y), 1 + len(y) // (ENDS + 1))
    begins, ends = (tried[each] for each in np.triu_indices(len(tried), k=FEWEST))
    r = np.clip((nights - nights[begins][:, None]) / (nights[ends] - nights[begins])[:, None], 0.0, 1.0)
    centred, off = r - r.mean(axis=1, keepdims=True), y - y.mean()
    explained = (centred @ off) ** 2 / (centred**2).sum(axis=1)
    return float((off**2).sum() - explained.max())
