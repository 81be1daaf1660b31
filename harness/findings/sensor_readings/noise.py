"""What is found of a channel's noise beside what its law says, and how sure a finding is."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.student import Z_95, wilson_interval
from plumbline.harness.trajectory import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Found, with 95 % intervals, and by law; None where the law has no such part or the readings cannot tell.

    Terms:
        law: in words. count: of readings that the spread is taken from. sigma: standard deviation from reading to reading,
        over all readings together. bias: mean deviation. lost: share of returns that got lost.
        white, floor, walk: Allan deviation over the law's, where that process is strongest. why: what cannot be told.
    """

    law: str
    count: int = 0
    sigma: Interval | None = None
    sigma_law: float | None = None
    bias: Interval | None = None
    bias_law: float | None = None
    lost: Interval | None = None
    lost_law: float | None = None
    white: float | None = None
    floor: float | None = None
    walk: float | None = None
    why: str = ""


@dataclass(frozen=True, slots=True)
class NoiseCurve:
    """What was found of noise beside its law, as a chart draws it, (k,) each: the Allan deviation over averaging times [s], the
    density of range errors over their standard deviation by law, or the spread of depth errors [m] over depths [m].

    Terms: low, high: where 95 % of findings lie if the law holds; of a spread, its own 95 % interval. count: of readings that a
    density is of; beyond: those outside of all its bins.
    """

    at: Floats
    found: Floats
    law: Floats
    low: Floats
    high: Floats
    count: int = 0
    beyond: int = 0


SILENT = Noise(law="")
"""Of a channel without noise."""


def spread_interval(sigma: float, freedom: float) -> Interval:
    """A standard deviation with so many degrees of freedom, by the chi-squared law of its square."""
    from scipy import stats  # late: a listing must not pay for it

    if not (math.isfinite(sigma) and freedom >= 1):
        return Interval(sigma, math.nan, math.nan)
    high, low = stats.chi2.ppf(0.025, freedom), stats.chi2.ppf(0.975, freedom)
    return Interval(sigma, sigma * math.sqrt(freedom / low), sigma * math.sqrt(freedom / high))


def lost_share(lost: int, count: int, law: float) -> dict[str, Any]:
    """The fields of `Noise` about returns that got lost, with Wilson's interval; none where nothing could get lost."""
    if count == 0:
        return {}
    return {"lost": Interval(lost / count, *wilson_interval(lost, count)), "lost_law": law}


def spread(deviation: Floats, law: Floats) -> dict[str, Any]:
    """The fields of `Noise` about spread and mean of independent deviations (n,), whose standard deviations by law are (n,)."""
    n = len(deviation)
    sigma, bias = spread_interval(float(np.sqrt(np.mean(np.square(deviation)))), n), float(np.mean(deviation))
    # The law is known, so the interval of the mean is that of a known variance.
    width = Z_95 * float(np.sqrt(np.mean(np.square(law)) / n))
    by_law = float(np.sqrt(np.mean(np.square(law))))
    return {"sigma": sigma, "sigma_law": by_law, "bias": Interval(bias, bias - width, bias + width), "bias_law": 0.0}
