"""Richardson extrapolation: a ladder of runs taken to a step of zero, with an error bar.

Runs f_1 .. f_m are made with n_1 < .. < n_m steps a unit of time. With a method of order p, f = f_0 + c n^-p + ..., so that

    R_i = (n_{i+1}^p f_{i+1} - n_i^p f_i) / (n_{i+1}^p - n_i^p)

lose the first term, and what is left of their differences tells how well. The four finest runs are looked at. Where the
differences of the R_i are at most a quarter of the differences of the runs themselves, the order counts as seen: the limit is
the last R and its bar

    1.25 max(|R_3 - R_2|, |R_2 - R_1| (n_2 / n_3)^(p+1)),

the second brought to the step of the first. Both are asked for because an event within a step leaves an error whose size
depends on where within the step it falls, and one difference may be small by chance. Three runs have one such difference
alone, and it is taken three times. Of several orders that are seen, that with the least bar is taken. Where none is, nothing
may be extrapolated: the limit is the finest run and its bar 3 max_i |f_{i+1} - f_i| n_{i+1} / n_m, the error of a first-order
method seen from each difference, three times over. Round-off of all steps is added.

Source: Richardson, Phil. Trans. R. Soc. A 210, 1911; Roache, J. Fluids Eng. 116, 1994 (grid convergence index: safety 1.25
where the order is observed on three grids or more, 3 where it is not).

Does a ladder of runs converge, up to when, and with what order: read off how far each halving of the step moves the answer.

Differences D_i(t) of neighbouring runs, each the largest up to t, shrink like h^p where a method of order p converges. They
count as shrinking at t where the line through log D_i over log h_i, of the last four of them, has a slope of 1/2 at least,
which is nearer to the first order, the lowest that a method has, than to none, and the last is the smallest. Where the last
two lie below a tenth of the tolerance they need not shrink: that is a floor, of rounding or of a solver that iterates, and
three times it, the error bar without an order, stays within the tolerance. Where limits may lie further apart than that, as
contacts may, a third of what they are granted is the floor: three times it is then no more than that.

The limit is **known** up to the time at which its error bar leaves the tolerance, or at which the differences no longer shrink,
whichever comes first. The **horizon** is the time up to which the last halving itself moves the answer by no more than the
tolerance. Chaos and contacts end both: there neighbouring runs part like exp(L t), and no step that could be paid for brings
them together again.

Source: Roache, J. Fluids Eng. 116, 1994 (observed order); Erez, Tassa & Todorov, ICRA 2015 (an engine against itself at a finer
step); Lighthill, Proc. R. Soc. A 407, 1986 (horizon of predictability).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Size: TypeAlias = Callable[[Floats], Floats]
"""From values (t, ...) to their sizes (t,)."""

OBSERVED, UNSEEN = 1.25, 3.0
"""Roache's factors of safety with and without an observed order."""
REGULAR = 0.25
"""Largest difference of extrapolants, relative to that of runs, at which an order counts as seen."""
FINEST = 4
"""Runs that are looked at: coarser ones say little of the fine end."""
ORDERS = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True)
class Extrapolation:
    """A value at a step of zero, its error bar in the same unit, and the order that the finer runs show (nan: none)."""

    value: Floats
    error: float
    order: float


@dataclass(frozen=True, slots=True)
class ZeroStepLimit:
    """Values (t, ...) at a step of zero, the error bar up to each sample (t,), and the order that each rests on (t,), 0:
    none."""

    value: Floats
    bar: Floats
    order: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class _Route:
    """One way to a step of zero. Terms: value (t, ...). bar (t,): infinite where the way is closed. order: 0 for the finest
    run."""

    value: Floats
    bar: Floats
    order: int


def _largest(values: Floats) -> Floats:
    """The largest component at each sample."""
    largest: Floats = np.abs(values).reshape(len(values), -1).max(axis=1, initial=0.0)
    return largest


def _routes(
    runs: Sequence[Floats], rates: Sequence[float], round_off: Floats, size: Size, orders: Sequence[int]
) -> Iterator[_Route]:
    """All ways to a step of zero from these runs; the last one is never closed. Bars only grow with time."""
    n = np.array(rates, float)
    moved = [np.maximum.accumulate(size(finer - coarser)) for coarser, finer in pairwise(runs)]
    for p in orders if len(runs) > 2 else ():
        w = n**p
        made = [(w[i + 1] * runs[i + 1] - w[i] * runs[i]) / (w[i + 1] - w[i]) for i in range(len(runs) - 1)]
        left = [np.maximum.accumulate(size(finer - coarser)) for coarser, finer in pairwise(made)]
        # An extrapolant multiplies the round-off of its runs by about three.
        seen = np.all([rest <= REGULAR * way + 6.0 * round_off for rest, way in zip(left, moved, strict=False)], axis=0)
        # left[k] is that of steps n[k] .. n[k + 2], and shrinks with the next power of them.
        brought = [rest * (n[k + 1] / n[-2]) ** (p + 1) for k, rest in enumerate(left)]
        safety = OBSERVED if len(left) > 1 else UNSEEN
        yield _Route(made[-1], np.where(seen, safety * np.max(brought, axis=0) + 3.0 * round_off, np.inf), p)
    rest = UNSEEN * np.max([way * n[i + 1] / n[-1] for i, way in enumerate(moved)], axis=0)
    yield _Route(runs[-1], rest + round_off, 0)


def extrapolate(
    runs: Sequence[Floats], rates: Sequence[float], round_off: float, orders: Sequence[int] = (1,)
) -> Extrapolation:
    """All samples taken to a step of zero in one way, with one bar.

    Args: runs: each (t, ...), from coarse to fine, two at least. rates: steps of each a unit of time. round_off: what the
        arithmetic of the finest run may have cost, in the unit of the values. orders: what may be seen.
    """
    runs, rates = runs[-FINEST:], rates[-FINEST:]
    blank = np.full(len(runs[-1]), round_off)
    *seen, finest = _routes(runs, rates, blank, _largest, orders)
    least = min(seen, key=lambda route: float(route.bar.max(initial=0.0)), default=finest)
    best = least if np.isfinite(least.bar).all() else finest
    order = float("nan")
    if len(runs) > 2:
        before, last = (float(_largest(b - a).max(initial=0.0)) for a, b in list(pairwise(runs))[-2:])
        order = observed_order(before / last, rates[-3:]) if min(before, last) > round_off else order
    return Extrapolation(best.value, float(best.bar.max(initial=0.0)), order)


def limit(runs: Sequence[Floats], rates: Sequence[float], round_off: Floats, size: Size) -> ZeroStepLimit:
    """Each sample taken to a step of zero in the way that has the least bar up to there.

    Args: runs: each (t, ...), from coarse to fine, two at least. rates: steps of each a unit of time. round_off (t,): what the
        arithmetic of the finest run may have cost up to each sample. size: of differences, in the unit of the bars.
    """
    ways = list(_routes(runs[-FINEST:], rates[-FINEST:], round_off, size, ORDERS))
    bars = np.stack([way.bar for way in ways])
    taken = np.argmin(bars, axis=0)
    at = np.arange(len(taken))
    value = np.stack([way.value for way in ways])[taken, at]
    return ZeroStepLimit(value, np.maximum.accumulate(bars[taken, at]), np.array([way.order for way in ways])[taken])


def observed_order(ratio: float, rates: Sequence[float]) -> float:
    """The p at which (n_1^-p - n_2^-p) / (n_2^-p - n_3^-p), which grows with p, is the ratio seen; within 0.1..8."""
    p, n = np.linspace(0.1, 8.0, 791), np.array(rates, float)
    return float(np.interp(ratio, (n[0] ** -p - n[1] ** -p) / (n[1] ** -p - n[2] ** -p), p))


Ended: TypeAlias = Literal["end", "horizon", "no shrinking"]

SHRINKS = 0.5
FLOOR = 0.1
"""Of the tolerance: below it differences need not shrink."""
EXACT = 1e-7
"""Of the tolerance: below it runs are equal, but for rounding."""
LAST = 4
"""Differences that a slope is read off: coarser ones may lie beyond where the order shows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Convergence:
    """How far a ladder converges.

    Terms:
        until [s]: up to there the limit is known, None where it never is; ended: by what. horizon [s]: up to there the last
        halving stays within the tolerance. order: the slope at `until`, None where only a floor is left or nothing is known.
        moved: what the last halving moves up to `until`. regular: the share of the samples up to there at which runs are
        equal or draw together; elsewhere they stay apart, and are near each other because little has happened yet.
    """

    until: float | None
    ended: Ended
    horizon: float
    order: float | None
    moved: float
    regular: float


def horizon(time: Floats, apart: Floats, tolerance: float) -> float:
    """The last sample [s] up to which a distance (t,) has stayed within the tolerance; what is not a number has not."""
    beyond = np.flatnonzero(~(apart <= tolerance))
    return float(time[-1]) if not len(beyond) else float(time[max(int(beyond[0]) - 1, 0)])


def slopes(steps: Sequence[float], moved: Floats) -> Floats:
    """The slope of log moved over log step by least squares at each sample, (t,).

    Args: steps (k,) [s]: the coarser of each two runs. moved (k, t): their differences, positive.
    """
    x = np.log(np.array(steps, float))
    x = x - x.mean()
    slope: Floats = x @ np.log(moved) / float(x @ x)
    return slope


def convergence(
    time: Floats, steps: Sequence[float], apart: Floats, bar: Floats, tolerance: float, granted: float = 0.0
) -> Convergence:
    """What a ladder of three runs or more says of itself.

    Args: time (t,) s. steps (k + 1,) [s], falling. apart (k, t): distances of neighbouring runs at each sample. bar (t,): the
        error bar of their limit up to there. tolerance, granted: what limits may lie apart; in the unit of both.
    """
    moved = np.maximum.accumulate(np.where(np.isfinite(apart), apart, np.inf), axis=1)[-LAST:]
    with np.errstate(invalid="ignore"):  # where two runs have left the numbers there is no slope, and nothing shrinks
        slope = slopes(list(steps[:-1])[-LAST:], np.maximum(moved, np.finfo(np.float64).tiny))
    shrinks = (slope >= SHRINKS) & (moved[-1] <= moved.min(axis=0)) & np.isfinite(moved[-1])
    sound = shrinks | (moved[-2:].max(axis=0) <= max(FLOOR * tolerance, granted / UNSEEN))
    lost = np.flatnonzero(~(sound & (bar <= tolerance)))
    last = len(time) - 1 if not len(lost) else int(lost[0]) - 1
    ended: Ended = "end" if not len(lost) else "horizon" if sound[lost[0]] else "no shrinking"
    drawn = shrinks | (moved[-2:].max(axis=0) <= EXACT * tolerance)
    return Convergence(
        until=float(time[last]) if last >= 0 else None,
        ended=ended,
        horizon=horizon(time, moved[-1], tolerance),
        order=float(slope[last]) if last >= 0 and shrinks[last] and moved[-1, last] > 0 else None,
        moved=float(moved[-1, max(last, 0)]),
        regular=float(drawn[: last + 1].mean()) if last >= 0 else 0.0,
    )
