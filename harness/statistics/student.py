"""Student's t: percentiles, tails, and the means of small samples with their intervals.

From `scipy.special` alone; `scipy.stats` hands on the same and costs half a second more.

Source: Student, Biometrika 6 (1908) 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.99
"""Of an interval: of ten that are compared pair by pair, half a pair is told apart by chance at 99 %, and two at 95 %."""


def percentile(share: float, freedom: float) -> float:
    """What a share of all values lies below. Args: freedom: degrees of freedom, above 0."""
    from scipy.special import stdtrit  # late: a listing must not pay for it

    return float(stdtrit(freedom, share))


def tail(value: float, freedom: float) -> float:
    """The probability of more than a value; NaN without degrees of freedom."""
    from scipy.special import stdtr  # late, too

    return float(stdtr(freedom, -value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Mean:
    """Terms: value; half: half of its interval at `CONFIDENCE`, infinite for less than two samples; count."""

    value: float
    half: float
    count: int


def mean_of(samples: Sequence[float]) -> Mean:
    """The mean with Student's interval; of samples that are not finite it is NaN.

    Source: Student, Biometrika 6 (1908) 1.
    """
    values = np.array(samples, float)
    n = len(values)
    if n < 2:
        return Mean(value=float(values.mean()) if n else float("nan"), half=float("inf"), count=n)
    error = float(values.std(ddof=1)) / n**0.5
    return Mean(value=float(values.mean()), half=percentile(0.5 + CONFIDENCE / 2, n - 1) * error, count=n)


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
