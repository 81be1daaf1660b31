"""Does a ladder of runs converge, up to when, and with what order: read off how far each halving of the step moves the answer.

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

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.statistics.richardson import UNSEEN

Floats: TypeAlias = NDArray[np.float64]
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
