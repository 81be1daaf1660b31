"""Scores of noise against its law, of deviations (n,) that are independent standard normal variables where the law holds.

Each score is of the order of 1 then.
"""

import numpy as np

from plumbline.harness.trajectory import Floats


def mean_score(deviations: Floats) -> float:
    """The mean over its standard error."""
    return float(abs(deviations.mean()) * np.sqrt(len(deviations)))


def cube_root_score(level: float, freedom: float) -> float:
    """A chi-squared variable over its degrees of freedom: Wilson and Hilferty's cube root makes it normal."""
    third = 2.0 / (9.0 * freedom)
    return float(abs(level ** (1 / 3) - (1 - third)) / np.sqrt(third))


def spread_score(deviations: Floats) -> float:
    """The mean square, to one part in n."""
    return cube_root_score(float(np.mean(np.square(deviations))), len(deviations))


def kolmogorov_distance(deviations: Floats) -> float:
    """sqrt(n) D from the standard normal distribution; NaN where a deviation is."""
    from scipy import stats  # late: a listing must not pay for it

    if np.isnan(deviations).any():
        return float("nan")
    # The statistic is the same by any method; this one spends nothing on the p-value, which takes most of the time otherwise.
    return float(stats.kstest(deviations, "norm", method="asymp").statistic * np.sqrt(len(deviations)))


def neighbour_scores(deviation: Floats, least: int) -> list[float]:
    """Correlations of neighbours along each axis of (a, b, c) deviations, infinite where there is none, of at least so many
    pairs: the mean product of deviations is 1/sqrt(n) wide."""
    scores = []
    for axis in range(3):
        count = deviation.shape[axis]
        a, b = (deviation.take(np.arange(start, count - 1 + start), axis=axis).ravel() for start in (0, 1))
        both = ~np.isinf(a) & ~np.isinf(b)
        if both.sum() >= least:
            scores.append(float(abs(np.mean(a[both] * b[both])) * np.sqrt(both.sum())))
    return scores


def share_score(share: float, law: float, count: int) -> float:
    """A share of `count` against its law's, in the standard deviations that the law gives it.

    A score below z says that Wilson's interval for confidence z, drawn about the observed share, holds the law's.
    """
    width = float(np.sqrt(law * (1 - law) / count))
    return abs(share - law) / width if width > 0 else (0.0 if share == law else float("inf"))
