"""Change points: the nights from which on a series lies on another level; and slopes that look like two of them.

Candidates are the exact optimum of PELT (R. Killick, P. Fearnhead & I. A. Eckley, J. Amer. Statist. Assoc. 107 (2012) 1590) on
logarithms whose outliers are clipped. Each is then moved to the night about which it most likely lies: the middle of the three
that hold most of the posterior probability, by squares around the levels, capped. The weakest are dropped, one after the other,
until what is left is beyond chance: Student's t of the two levels beside it, counted once for each night that it could have
been (Bonferroni). docs/decisions/0016 says how often that finds what, what could be found at best, and what else was tried.
"""

import math
import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.student import tail

Floats: TypeAlias = NDArray[np.float64]

CHANCE = 1e-3
"""Of a series: how often chance alone may look like a change of it."""
LEAST = 0.01
"""Changes of a price below one in a hundred are nobody's concern, however sure."""
FEWEST = 3
"""Nights on a level: with two, one outlier would be half of it."""
ORDINARY = 0.7
"""Share of a level's nights that have to lie on it: a few outliers in a row are no level."""
CAP, CLIP, HALF = 3.0, 2.5, 3
"""An outlier lies three spreads off its level; before levels are known, values are clipped at two and a half from the middle of
the seven nights around them."""
PENALTY = 10.0
"""Of a candidate, in squared spreads: below what the test asks for, so that the test decides."""
SHIFT = 6
"""Nights by which a candidate may be moved."""
OUTLIERS = 0.03
"""Share of nights on which a price is one."""
SHORTEST = 2 * FEWEST + 2
"""Nights that have a spread."""
TINY = 1e-6
"""Spread of a series that hardly varies: there is no t of none."""
_NORMAL_MAD = 0.6745
_NORMAL_CAPPED = 0.9866
"""Of a normal distribution with spread 1: its median absolute deviation, and its spread within three."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangePoint:
    """Terms: index: of the first value on the new level. ratio: new level over old. p_value: how often chance does as much.
    error: standard error of the ratio's logarithm."""

    index: int
    ratio: float
    p_value: float
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """What a series lies on between two change points. Terms: first, last: indices of its values. value: their middle. low,
    high: the fence, three spreads from it; both the value where so few nights have no spread."""

    first: int
    last: int
    value: float
    low: float
    high: float


def change_points(series: Floats, segments: NDArray[np.int64] | None = None, chance: float = CHANCE) -> tuple[ChangePoint, ...]:
    """The change points of a series, shape (n,), positive, one value a night, NaN for a night without one; in order.

    Args: segments (n,): nights of different numbers (another version, another machine) are never compared; one for all if None.
    chance: how often chance alone may look like a change of this series.
    """
    numbers = np.zeros(len(series), np.int64) if segments is None else segments
    usable = np.isfinite(series) & (series > 0)
    made: list[ChangePoint] = []
    for number in dict.fromkeys(numbers.tolist()):
        nights = np.flatnonzero(usable & (numbers == number))
        for at, step in _of_log(np.log(series[nights]), chance):
            made.append(
                ChangePoint(index=int(nights[at]), ratio=float(np.exp(step.size)), p_value=step.p_value, error=step.error)
            )
    return tuple(sorted(made, key=lambda point: point.index))


def levels(series: Floats, steps: Collection[int], segments: NDArray[np.int64] | None = None) -> tuple[Level, ...]:
    """The levels of a series (n,) between steps, segment by segment, each with its own fence; in order.

    Args: steps: indices of the first night on each new level.
    """
    numbers = np.zeros(len(series), np.int64) if segments is None else segments
    usable, made = np.isfinite(series) & (series > 0), list[Level]()
    for number in dict.fromkeys(numbers.tolist()):
        nights = np.flatnonzero(usable & (numbers == number))
        if len(nights) == 0:
            continue
        y = np.log(series[nights])
        ends = [int(np.searchsorted(nights, step)) for step in sorted(set(steps)) if nights[0] < step <= nights[-1]]
        spread = _spread(y, ends) if len(y) >= SHORTEST else 0.0
        for a, b in pairwise([0, *ends, len(y)]):
            middle = _level(y[a:b], max(spread, TINY))[0]
            made.append(
                Level(
                    first=int(nights[a]),
                    last=int(nights[b - 1]),
                    value=float(np.exp(middle)),
                    low=float(np.exp(middle - CAP * spread)),
                    high=float(np.exp(middle + CAP * spread)),
                )
            )
    return tuple(sorted(made, key=lambda level: level.first))


def common_mode(series: Floats) -> Floats:
    """The factor (n,) by which each night slowed all series, shape (s, n): the median over series of each one's departure
    from its own median; 1 where no series has a value. Several series over it are free of what the machine did to all."""
    logs = np.log(np.where(series > 0, series, np.nan))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a night or a series without any value
        factor: Floats = np.exp(np.nanmedian(logs - np.nanmedian(logs, axis=1, keepdims=True), axis=0))
    return np.nan_to_num(factor, nan=1.0)


def levelled(series: Floats) -> Floats:
    """Several series (s, n) that should move together as one (n,), of less noise: the geometric mean of each over its median,
    outliers clipped.

    A step of 5 % in one series with 2 % noise is hardly placed to the night; in four of them it is.
    """
    logs = np.full(series.shape, np.nan)
    for row, values in zip(logs, series, strict=True):
        nights = np.flatnonzero(np.isfinite(values) & (values > 0))
        if len(nights) > 1:
            row[nights] = without_outliers(np.log(values[nights]))[0]
            row -= np.median(row[nights])
    there = np.isfinite(logs).any(axis=0)
    mean = np.full(series.shape[1], np.nan)
    mean[there] = np.exp(np.nanmean(logs[:, there], axis=0))
    return mean


@dataclass(frozen=True, slots=True)
class _Step:
    """Between two levels of logarithms. Terms: size, with its standard error; p_value."""

    size: float
    p_value: float
    error: float


def _of_log(y: Floats, chance: float) -> list[tuple[int, _Step]]:
    """Index and step of each change in logarithms (n,), all finite."""
    if len(y) < SHORTEST:
        return []  # a spread of so few values is none
    ends = _candidates(y)
    while ends:
        spread = _spread(y, ends)
        for _ in range(2):
            ends = _moved(y, ends, spread)
        tests = [_test(y, *around, spread) for around in _around(ends, len(y))]
        weakest = max(range(len(ends)), key=lambda k: tests[k].p_value)
        if tests[weakest].p_value < chance:
            return list(zip(ends, tests, strict=True))
        del ends[weakest]
    return []


def _candidates(y: Floats) -> list[int]:
    from ruptures import KernelCPD  # late: a listing must not pay for it

    clipped, spread = without_outliers(y)
    changes: list[int] = KernelCPD(kernel="linear", min_size=FEWEST).fit(clipped[:, None] / spread).predict(pen=PENALTY)[:-1]
    return changes


def without_outliers(y: Floats) -> tuple[Floats, float]:
    """Logarithms (n,) without outliers, and their spread from night to night."""
    steps = np.diff(y)
    spread = max(float(np.median(np.abs(steps - np.median(steps)))) / _NORMAL_MAD / 2**0.5, TINY)
    middle = np.array([np.median(y[max(0, k - HALF) : k + HALF + 1]) for k in range(len(y))])
    return np.clip(y, middle - CLIP * spread, middle + CLIP * spread), spread


def _around(ends: Sequence[int], length: int) -> list[tuple[int, int, int]]:
    """Each change with the ends of the levels beside it."""
    bounds = [0, *ends, length]
    return [(bounds[k - 1], bounds[k], bounds[k + 1]) for k in range(1, len(bounds) - 1)]


def _level(values: Floats, spread: float) -> tuple[float, int]:
    """The mean of what lies within the cap around it, begun at the median, and how many those are."""
    level, within = float(np.median(values)), np.ones(len(values), np.bool_)
    for _ in range(3):
        within = np.abs(values - level) <= CAP * spread
        if not within.any():
            return level, 0
        level = float(values[within].mean())
    return level, int(within.sum())


def _spread(y: Floats, ends: Sequence[int]) -> float:
    """The spread around the levels, without outliers."""
    bounds = [0, *ends, len(y)]
    off = np.concatenate([y[a:b] - np.median(y[a:b]) for a, b in pairwise(bounds)])
    rough = max(float(np.median(np.abs(off))) / _NORMAL_MAD, TINY)
    within = np.abs(off) <= CAP * rough
    free = max(int(within.sum()) - len(ends) - 1, 1)
    return max(float(np.sqrt((off[within] ** 2).sum() / free)) / _NORMAL_CAPPED, TINY)


def _moved(y: Floats, ends: Sequence[int], spread: float) -> list[int]:
    """Each change in the middle of the three nights that most likely hold it: exp(-q/2) is how likely a night is of which the
    squares around the levels beside it, capped, sum to q. The likeliest single night is off by more than one in every eighth
    step of 5 % at 2 % noise, this one in every fourteenth."""
    bounds = [0, *ends, len(y)]
    for k in range(1, len(bounds) - 1):
        start, at, end = bounds[k - 1 : k + 2]
        tried = range(max(start + FEWEST, at - SHIFT), min(end - FEWEST, at + SHIFT) + 1)
        if len(tried) == 0:
            continue
        squares = np.array([_capped(y[start:cut], spread) + _capped(y[cut:end], spread) for cut in tried])
        likely = np.pad(np.exp((squares.min() - squares) / 2), 1)
        bounds[k] = tried[int(np.argmax(likely[:-2] + likely[1:-1] + likely[2:]))]
    return bounds[1:-1]


def _capped(values: Floats, spread: float) -> float:
    off = (values - _level(values, spread)[0]) / spread
    return float(np.minimum(off**2, CAP**2).sum())


def _test(y: Floats, start: int, at: int, end: int, spread: float) -> _Step:
    """The step between two levels, and how often chance alone makes one as sure anywhere in the series.

    Beside another change its night was chosen together with that one's, so that there were as many pairs. Levels that far apart
    that one would be outliers of the other are also as likely as so many outliers in a row.
    """
    (low, few), (high, many) = _level(y[start:at], spread), _level(y[at:end], spread)
    if few < max(FEWEST, ORDINARY * (at - start)) or many < max(FEWEST, ORDINARY * (end - at)) or abs(high - low) < LEAST:
        return _Step(high - low, 1.0, math.inf)
    error = spread * (1 / few + 1 / many) ** 0.5
    places = (len(y) - 1) ** (1 if start == 0 and end == len(y) else 2)
    chance = 2 * tail(abs(high - low) / error, len(y) - 3) * places
    if abs(high - low) > CAP * spread:
        chance = max(chance, len(y) * OUTLIERS ** min(few, many))
    return _Step(high - low, min(1.0, chance), error)


MARGIN = 6.0
"""Squared spreads by which two steps have to fit better than a slope: exp(-6/2) is a chance of one in twenty."""
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
