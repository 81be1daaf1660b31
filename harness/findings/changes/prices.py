"""Prices of two runs, each over something that was clocked in the same run, since a machine is never twice as fast.

Best are the prices of other engines whose answers are the same to the last bit: they pass through the same hours. Where there
are too few of them, it is the canary, a fixed kernel clocked beside each sample. Even then a process is laid out otherwise in
memory the next time: how far prices of unchanged trials stray from run to run is read off them, and nothing below four times
that, or below what marks a timing as unstable, is told of a single trial; nor what is within the 99 % interval of its own
samples, widened to Student's, since three samples say little of how far they stray. Of an engine as a whole less can be told,
by the median. Where the clock ran over another part of the motion (a run too long for a sample), nothing is compared.

Whatever else wants the processor comes for seconds or minutes, and then meets all that is clocked side by side: one question,
put to all engines in turn. So a price of one trial has to stand out from the other engines at the same question, by what
unchanged prices stray from each other there, and from the run as a whole too; the smaller of both changes is told. Other work
does not slow all engines alike: where the others at a question strayed farther from each other, that is how far one more may.

Where no other engine was clocked at a question, only the canary beside each sample saw who else wanted the processor. It and an
engine need not be slowed alike: of what the canary moved by, the engine may have taken nothing or twice as much. So a price has
to stand out by more than the canary moved there, and by more than both stray together from sample to sample.
"""

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from plumbline.harness.findings.changes.matching import TrialPair, located
from plumbline.harness.findings.changes.values import Beside, Change, Sense
from plumbline.harness.statistics.bootstrap import interval_of_drawn
from plumbline.harness.statistics.student import percentile
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats, Integers

DRAWS = 400
"""Of the bootstrap: enough for the 2.5th and 97.5th of a hundred to be told from their neighbours."""
FEWEST = 8
"""Prices of other engines that make a yardstick, and of any that make a spread."""
TOLD = 0.10
"""Of one trial; half an interval as wide as this marks a timing as unstable."""
TOLD_OF_ALL = 0.05
"""Of an engine as a whole."""
CERTAIN = 4.0
"""Spreads: of a thousand unchanged prices, one is beyond them in sixteen nights."""
Z_95 = 1.96
_NORMAL_MAD = 0.6745
_MEDIAN_ERROR = 1.2533
"""Standard error of a median over that of a mean."""


@dataclass(frozen=True, slots=True)
class _Price:
    """A pair that was clocked on both sides.

    Terms: step: logarithm of the ratio of the medians; canary: likewise; before, after: the samples, None where not kept;
    steady: the same bits, by the same version and sources; unstable: is either marked so?
    """

    pair: TrialPair
    step: float
    canary: float
    before: "_Samples | None"
    after: "_Samples | None"
    steady: bool
    unstable: bool

    def halves(self) -> tuple[float, float]:
        """Half the bootstrap interval of the step of 95 % and of 99 %, widened to Student's; 0 where no samples were kept."""
        if self.before is None or self.after is None:
            return 0.0, 0.0
        count = min(len(self.before.cost), len(self.after.cost))
        return _halves(_drawn(self.after.cost) - _drawn(self.before.cost), count)

    def halves_over(self) -> tuple[float, float]:
        """Likewise of the step over the canary, sample by sample, and no less."""
        if self.before is None or self.after is None:
            return 0.0, 0.0
        count = min(len(self.before.cost), len(self.after.cost))
        own = _drawn(self.after.cost) - _drawn(self.before.cost)
        over = own - _drawn(self.after.canary) + _drawn(self.before.canary)  # of the same samples
        (half, sure), (half_over, sure_over) = _halves(own, count), _halves(over, count)
        return max(half, half_over), max(sure, sure_over)


@dataclass(frozen=True, slots=True)
class _Yardstick:
    """What an engine's prices are divided by. Terms: step: its logarithm from A to B; error: standard error of that; spread: of
    unchanged prices from run to run, in logarithms; canary: the logarithm of its motion over the run, where it is not the step.
    """

    beside: Beside
    step: float
    error: float
    spread: float
    canary: float = 0.0


@dataclass(frozen=True, slots=True)
class _Neighbours:
    """Unchanged prices of other engines at one question.

    Terms: step: logarithm of their common motion. error: its standard error. spread: of unchanged prices about the common
    motion of their question, in logarithms: over all questions, and no less than that of this one.
    """

    step: float
    error: float
    spread: float


@dataclass(frozen=True, slots=True)
class _Samples:
    """Of one trial. Terms: cost [s] of a unit, canary [s], each (k,). steps: of the first sample; run: of a whole run, 0 for
    casts and calls and where that is not known."""

    cost: Floats
    canary: Floats
    steps: int
    run: int


def clocked(pairs: Sequence[TrialPair]) -> list[TrialPair]:
    """The pairs with a price on both sides."""
    return [pair for pair in pairs if all((row.cpu_per_unit or 0.0) > 0 for row in (pair.a, pair.b))]


def judged_prices(store_a: Store, store_b: Store, pairs: Sequence[TrialPair]) -> list[TrialPair]:
    """Of the pairs those whose prices can be judged: of the same motion, and stable on both sides."""
    before, after = _samples(store_a), _samples(store_b)
    same = [pair for pair in clocked(pairs) if _same_motion(pair, before, after)]
    return [pair for pair in same if not any(_unstable(row.unstable_timing) for row in (pair.a, pair.b))]


def price_changes(
    store_a: Store, store_b: Store, pairs: Sequence[TrialPair], about: Callable[[Any], bool] = lambda _row: True
) -> Iterator[Change]:
    """A row for each trial, and one for each engine, whose price changed beyond doubt; and for each trial that is dearer beyond
    its own interval, by a timing too unstable to judge by.

    Args: about: of which rows of the table `trials` of B it is; the others are clocked beside.
    """
    before, after = _samples(store_a), _samples(store_b)
    same = [pair for pair in clocked(pairs) if _same_motion(pair, before, after)]
    prices = [_price(pair, before, after) for pair in same]
    for engine in dict.fromkeys(price.pair.b.engine for price in prices):
        mine = [price for price in prices if price.pair.b.engine == engine and about(price.pair.b)]
        if not mine:
            continue
        others = [price for price in prices if price.pair.b.engine != engine and price.steady]
        by, beside = _yardstick(mine, others), _side_by_side(others)
        yield from _of_all(engine, mine, by)
        for price in mine:
            if (change := _of_one(price, by, beside.get(_question(price)), store_b.catalogue)) is not None:
                yield change


def _samples(store: Store) -> dict[str, _Samples]:
    """All samples by trial."""
    table = store.samples
    if table.empty:
        return {}
    cost = (table["cpu"] / (table["steps"] * table.get("units", 1))).to_numpy(float)
    canary, steps = table["canary"].to_numpy(float), table["steps"].to_numpy()
    run = np.broadcast_to(table.get("run", 0), len(table))  # a table of an older version has no such column
    return {
        str(trial): _Samples(cost[rows], canary[rows], int(steps[rows[0]]), int(run[rows[0]]))
        for trial, rows in table.groupby("trial").indices.items()
    }


def _same_motion(pair: TrialPair, a: Mapping[str, _Samples], b: Mapping[str, _Samples]) -> bool:
    """Did both clocks run over the same motion? Folders of older versions do not say what a whole run is, the others do."""
    before, after = a.get(pair.a.trial), b.get(pair.b.trial)
    if before is None or after is None:
        return True
    run = before.run or after.run
    return not run or (before.run in (0, run) and after.run in (0, run) and before.steps % run == after.steps % run == 0)


def _price(pair: TrialPair, a: Mapping[str, _Samples], b: Mapping[str, _Samples]) -> _Price:
    step = math.log(pair.b.cpu_per_unit / pair.a.cpu_per_unit)
    before, after, canary = a.get(pair.a.trial), b.get(pair.b.trial), 0.0
    if before is not None and after is not None:
        canary = math.log(float(np.median(after.canary)) / float(np.median(before.canary)))
    steady = (
        pair.same_bits
        and pair.a.engine_version == pair.b.engine_version
        and getattr(pair.a, "sources", "") == getattr(pair.b, "sources", "")
    )
    unstable = any(_unstable(row.unstable_timing) for row in (pair.a, pair.b))
    return _Price(pair=pair, step=step, canary=canary, before=before, after=after, steady=steady, unstable=unstable)


def _halves(drawn: Floats, count: int) -> tuple[float, float]:
    """Half the interval of 95 % and of 99 % of drawn values of so many samples, widened to Student's."""
    low, high = interval_of_drawn(drawn)
    return _student(count, 0.975) / Z_95 * (high - low) / 2, _student(count, 0.995) / Z_95 * (high - low) / 2


def _unstable(value: Any) -> bool:
    """Is a timing marked so, or is nothing said of it? Columns hold NA, NaN or None then."""
    return bool(value) if isinstance(value, bool | np.bool_) else True


@cache
def _student(count: int, share: float) -> float:
    """The percentile of Student's t of so many samples."""
    return percentile(share, max(count - 1, 1))


def _drawn(values: Floats) -> Floats:
    """Logarithms of medians of samples drawn again."""
    medians: Floats = np.log(np.median(values[_draws(len(values))], axis=1))
    return medians


@cache
def _draws(count: int) -> Integers:
    """Places among so many samples, drawn again and again, (`DRAWS`, count)."""
    draws: Integers = np.random.default_rng(0).integers(0, count, size=(DRAWS, count))
    return draws[np.random.default_rng(1).permutation(DRAWS)]


def _yardstick(mine: Sequence[_Price], others: Sequence[_Price]) -> _Yardstick:
    if len(others) >= FEWEST:
        steps = np.array([price.step for price in others])
        middle = float(np.median(steps))
        spread = float(np.median(np.abs(steps - middle))) / _NORMAL_MAD
        canary = float(np.median([price.canary for price in others]))
        return _Yardstick("other engines", middle, _MEDIAN_ERROR * spread / math.sqrt(len(steps)), spread, canary)
    steps = np.array([price.step - price.canary for price in mine])
    spread = float(np.median(np.abs(steps - np.median(steps)))) / _NORMAL_MAD if len(steps) >= FEWEST else TOLD / CERTAIN
    middle = float(np.median([price.canary for price in mine]))
    return _Yardstick("canary", middle, TOLD_OF_ALL / CERTAIN, spread)


def _question(price: _Price) -> Hashable:
    """What is clocked side by side has it in common."""
    b = price.pair.b
    return getattr(b, "experiment", ""), b.case, b.parameters


def _side_by_side(others: Sequence[_Price]) -> dict[Hashable, _Neighbours]:
    """By question, where there are two prices at least; nothing where there are too few of them for a spread."""
    asked = grouped(others, _question)
    steps = {question: np.array([price.step for price in prices]) for question, prices in asked.items() if len(prices) > 1}
    # About a middle of their own, n values stray by the n-th part of their variance too little.
    apart = [(of - np.median(of)) * math.sqrt(len(of) / (len(of) - 1)) for of in steps.values()]
    if sum(map(len, apart)) < FEWEST:
        return {}
    spread = float(np.median(np.abs(np.concatenate(apart)))) / _NORMAL_MAD
    # What an engine's settings have in common is that they are clocked in one process.
    engines = {question: len({price.pair.b.engine for price in asked[question]}) for question in steps}
    made = {}
    for question, of in steps.items():
        here = max(spread, float(np.std(of, ddof=1)))
        made[question] = _Neighbours(float(np.median(of)), _MEDIAN_ERROR * here / math.sqrt(engines[question]), here)
    return made


def _of_one(price: _Price, by: _Yardstick, beside: _Neighbours | None, catalogue: Mapping[str, Any]) -> Change | None:
    """A change beyond doubt; where a timing is unstable, a dearer price beyond its own interval, as unconfirmed."""
    whole, told, swing = price.step - (price.canary if by.beside == "canary" else by.step), math.log1p(TOLD), 0.0
    if beside is not None:
        step, error, spread = price.step - beside.step, beside.error, beside.spread
    else:
        swing = price.canary - by.canary
        step, error, spread = whole if by.beside == "canary" else whole - swing, by.error, by.spread
    if min(abs(step), abs(whole)) <= told or step * whole < 0.0:
        return None
    # Drawn for what may be told alone: of a thousand prices nearly all are where they were.
    half, sure = price.halves() if beside is not None else price.halves_over()
    own = max(half, sure, abs(swing))
    if price.unstable and step <= own:
        return None
    half = max(half, Z_95 * math.hypot(spread, error), abs(swing))
    if not price.unstable and abs(step) <= max(CERTAIN * math.hypot(spread, error), half, sure):
        return None
    step = min(step, whole, key=abs)
    sense: Sense = "unconfirmed" if price.unstable else "worse" if step > 0 else "better"
    b = price.pair.b
    return Change(
        kind="price",
        sense=sense,
        **located(price.pair.a, b, catalogue),
        metric=f"CPU time of a {b.unit}" if isinstance(b.unit, str) else "CPU time",
        unit="s",
        before=float(price.pair.a.cpu_per_unit),
        after=float(b.cpu_per_unit),
        ratio=math.exp(step),
        low=math.exp(step - half),
        high=math.exp(step + half),
        beside=by.beside,
    )


def _of_all(engine: str, mine: Sequence[_Price], by: _Yardstick) -> Iterator[Change]:
    if len(mine) < FEWEST:
        return
    steps = np.array([price.step for price in mine]) - by.step
    middle = float(np.median(steps))
    own = float(np.median(np.abs(steps - middle))) / _NORMAL_MAD
    error = math.hypot(_MEDIAN_ERROR * max(own, by.spread) / math.sqrt(len(steps)), by.error)
    half = max(Z_95 * error, abs(by.step) if by.beside == "canary" else 0.0)
    if abs(middle) <= max(math.log1p(TOLD_OF_ALL), CERTAIN * error, half):
        return
    yield Change(
        kind="price",
        sense="worse" if middle > 0 else "better",
        engine=engine,
        metric="CPU time",
        unit="1",
        before=1.0,
        after=math.exp(middle),
        ratio=math.exp(middle),
        low=math.exp(middle - half),
        high=math.exp(middle + half),
        beside=by.beside,
        count=len(mine),
    )
