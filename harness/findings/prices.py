"""The price list: what an error costs on each engine in each case, or "not within the ladder".

An engine's price is that of its cheapest group of settings. Between two time steps of one group it is interpolated, where the
error converges and does not jump; between two groups nothing lies that could be bought.

Errors are those of the case's headline, as shares of the case's scale; costs are CPU seconds per simulated second (of a unit
where that is no step). Both have error bars: costs those of their samples, errors that of the truth itself.

An error that no run comes down to is none that an engine could never reach: where the error of one of its settings shrinks
with the step, the step at which that trend would get there is foreseen.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from operator import attrgetter
from typing import Any, Literal

import numpy as np
import pandas as pd

from plumbline.harness.findings.agreement.found import errors_of
from plumbline.harness.findings.cost_point import CostPoint, Ended, Foreseen, SampledBlock, efforts, foreseen, samples_by_block
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import substeps_of, where_of
from plumbline.harness.statistics.bootstrap import drawn_in_groups, interval_of_drawn, medians, widening
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.pareto import on_front, price, prices_of_draws
from plumbline.harness.store.rows import grouped, number, records
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats

TARGETS = tuple(10.0**-k for k in range(1, 9))
"""Errors, as shares of a case's scale."""
LEAST = 1e-9
"""An error below this share of the scale is drawn and priced as this: there is no logarithm of none."""
DRAWS = 400
"""Of the bootstrap: enough for the 2.5th and 97.5th of a hundred to be told from their neighbours."""

PER_SECOND = "simulated second"

PriceVerdict = Literal["priced", "at most", "within the truth's error", "not within the ladder", "not clocked", "no answer"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached:
    """A target that is met.

    Terms: cost: with the 95 % interval. ratio: over the cheapest engine at this target that people can deploy; 1 for that
    engine itself, below 1 for the reference engine where it costs less; None where no such engine gets there. at: the point at
    or below the target that the price leans on. over: the next one of the same settings, which errs more; None where there is
    none, so that the price is an upper bound.
    """

    cost: Interval
    ratio: Interval | None
    at: CostPoint
    over: CostPoint | None

    @property
    def unstable(self) -> bool:
        """Was the timing of one of both points marked so?"""
        return self.at.unstable or (self.over is not None and self.over.unstable)


@dataclass(frozen=True, slots=True, kw_only=True)
class Beyond:
    """A target that no step and setting that was run comes down to. Terms: at: the most accurate clocked point. trend: where
    the target is met if errors go on shrinking as they do; None where none shrinks steadily."""

    at: CostPoint
    trend: Foreseen | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Silent:
    """What it costs is not known. Terms: verdict: 'not clocked' where no point that gets there has a time, and reason says what
    it roughly costs, where that is known; 'no answer' where no trial gave an error, and reason says why. at: the point that
    gets there, without a time."""

    verdict: Literal["not clocked", "no answer"]
    reason: str
    at: CostPoint | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Price:
    """What one target costs on one engine in one case.

    Terms: target: share of the scale. unit: what cost counts: 'simulated second', or 'ray' and the like. cheapest: of the
    engines that people can deploy. best: the most accurate of all its clocked points, finest: that of the finest step of all
    its points; None without one. tried: settings of the engine in this case whose answers differ; ended: why there are no more.
    """

    case: str
    where: str
    target: float
    engine: str
    unit: str
    outcome: Reached | Beyond | Silent
    cheapest: bool
    best: CostPoint | None
    finest: CostPoint | None
    tried: int
    ended: Ended

    @property
    def verdict(self) -> PriceVerdict:
        """priced; at most: the cheapest point already errs less; within the truth's error: the target is smaller than what the
        truth is known to; not within the ladder; or that of one that is silent."""
        match self.outcome:
            case Reached(at=at, over=over):
                return "within the truth's error" if self.target < at.off else "priced" if over is not None else "at most"
            case Beyond():
                return "not within the ladder"
            case silent:
                return silent.verdict

    @property
    def reached(self) -> Reached | None:
        """The outcome of a target that is met."""
        return self.outcome if isinstance(self.outcome, Reached) else None

    @property
    def unstable(self) -> bool:
        """Was a timing that it leans on marked so?"""
        return self.reached is not None and self.reached.unstable


class Prices:
    """Points and prices of a run folder, worked out once."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._draws: dict[tuple[str, str], Draws] = {}
        self._cases: Mapping[str, Mapping[str, Any]] = store.catalogue.get("cases", {})
        self._ours = {name for name, engine in store.catalogue.get("engines", {}).items() if engine.get("ours")}

    @cached_property
    def _headlines(self) -> Mapping[str, tuple[float, float]]:
        """Error and the truth's own error of each trial's headline, in its unit."""
        wanted = dict(
            zip(self._store.asked["trial"], (self._headline(case) for case in self._store.asked["case"]), strict=True)
        )
        headlines: dict[str, tuple[float, float]] = {}
        for row in records(self._store.measurements):
            if row["metric"] == wanted.get(row["trial"]) and row["trial"] not in headlines:
                headlines[row["trial"]] = (abs(number(row["value"])), number(row.get("truth_error", 0.0)))
        return headlines | {trial: (errors.error, errors.off) for trial, errors in errors_of(self._store).items()}

    def _headline(self, case: str) -> str:
        """The metric that is the case's error; none where more of it is better."""
        about = self._cases.get(case, {})
        headline = str(about.get("headline", ""))
        higher = any(check.get("better") == "higher" for check in about.get("checks", ()) if check.get("metric") == headline)
        return "" if higher else headline

    @cached_property
    def _samples(self) -> Mapping[str, Mapping[SampledBlock, float]]:
        """CPU seconds of a unit by trial and (process, block)."""
        timed = samples_by_block(self._store)
        return {trial: {block: sample.of_a_unit() for block, sample in blocks.items()} for trial, blocks in timed.items()}

    def groups(self) -> Iterator[tuple[str, str, pd.DataFrame]]:
        """The trials of one case at one set of parameters; where: what differs from the case's own, in words."""
        trials = self._store.asked
        for (case, parameters), group in trials.groupby(["case", "parameters"], sort=False):
            yield case, where_of(self._store.catalogue, case, parameters), group

    @cached_property
    def points(self) -> tuple[CostPoint, ...]:
        """Every trial that has an error and any cost, case by case and engine by engine."""
        points: list[CostPoint] = []
        for case, where, trials in self.groups():
            here = [point for row in records(trials) if (point := self._point(case, where, row)) is not None]
            clocked = [point for point in here if point.clocked]
            best = marked(clocked)
            fronts: set[str] = set()
            for engine in dict.fromkeys(point.engine for point in here):
                fronts |= marked([point for point in clocked if point.engine == engine])
            points += [replace(point, front=point.trial in fronts, best=point.trial in best) for point in here]
        return tuple(points)

    def _point(self, case: str, where: str, row: Mapping[str, Any]) -> CostPoint | None:
        if row["status"] not in ("passed", "failed") or row["trial"] not in self._headlines:
            return None
        error, off = self._headlines[row["trial"]]
        scale = float(self._cases.get(case, {}).get("scale") or 1.0)
        step = row.get("unit") in (None, "step") or pd.isna(row.get("unit"))
        kinds = ("cpu_per_sim_s", "cpu_low", "cpu_high") if step else ("cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high")
        cost, low, high = (number(row.get(name)) for name in kinds)
        clocked = math.isfinite(cost)
        if not clocked:
            cost = number(row.get("rough_cost"))
        if not (math.isfinite(error) and math.isfinite(cost) and cost > 0):
            return None
        return CostPoint(
            case=case,
            where=where,
            engine=row["engine"],
            track=row["track"],
            dt=float(row["dt"]),
            substeps=substeps_of(str(row["resolved"])),
            error=max(error / scale, LEAST),
            off=off / scale if math.isfinite(off) else 0.0,
            cost=Interval(cost, low, high) if clocked else Interval(cost),
            clocked=clocked,
            unstable=clocked and bool(row["unstable_timing"]),
            status=row["status"],
            trial=row["trial"],
            substep=float(row["dt"]) if math.isnan(number(row.get("substep"))) else float(row["substep"]),
            emulated=None if math.isnan(number(row.get("emulated"))) else float(row["emulated"]),
            front=False,
            best=False,
        )

    def draws(self, case: str, where: str) -> "Draws":
        """The resamples of all clocked points of a scene, drawn once."""
        if (case, where) not in self._draws:
            clocked = [point for point in self.by_scene.get((case, where), ()) if point.clocked]
            self._draws[case, where] = Draws(clocked, self._samples)
        return self._draws[case, where]

    def error(self, trial: str, case: str) -> float | None:
        """The error of a trial as a share of its case's scale; None where it has none."""
        error = self._headlines.get(trial, (math.nan, 0.0))[0]
        return error / float(self._cases.get(case, {}).get("scale") or 1.0) if math.isfinite(error) else None

    @cached_property
    def by_scene(self) -> Mapping[tuple[str, str], list[CostPoint]]:
        """The points of each case at one set of parameters."""
        return grouped(self.points, attrgetter("case", "where"))

    @cached_property
    def prices(self) -> tuple[Price, ...]:
        """One for each case, target and engine."""
        prices: list[Price] = []
        for case, where, trials in self.groups():
            if self._headline(case):
                prices += self._of_case(case, where, trials)
        return tuple(prices)

    def _of_case(self, case: str, where: str, trials: pd.DataFrame) -> Iterator[Price]:
        unit = unit_of(trials)
        here = self.by_scene.get((case, where), [])
        draw, targets = self.draws(case, where), np.array(TARGETS)
        of_engine = {engine: [p for p in here if p.engine == engine] for engine in dict.fromkeys(trials["engine"])}
        lists = {engine: List(mine, draw, targets) for engine, mine in of_engine.items()}
        lacking = {e: without(trials[trials["engine"] == e], here, e) for e, costs in lists.items() if costs.best is None}
        spent = efforts(self._store, trials)
        for k, target in enumerate(TARGETS):
            reached = {engine: costs.middle[k] for engine, costs in lists.items() if math.isfinite(costs.middle[k])}
            deployable = [engine for engine in reached if engine not in self._ours]
            cheapest = min(deployable, key=lambda engine: reached[engine], default="")
            for engine, costs in lists.items():
                mine = of_engine[engine]
                outcome: Reached | Beyond | Silent | None = lacking.get(engine)
                if engine in reached:
                    outcome = _reached(costs, k, lists.get(cheapest))
                elif costs.best is not None:
                    outcome = _unreached(mine, costs.best, target)
                assert outcome is not None
                yield Price(
                    case=case, where=where, target=target, engine=engine, unit=unit, outcome=outcome, best=costs.best,
                    cheapest=engine == cheapest, finest=min(mine, key=lambda point: point.dt, default=None),
                    tried=spent[engine][0], ended=spent[engine][1],
                )  # fmt: skip


def _reached(costs: "List", k: int, cheapest: "List | None") -> Reached:
    """The price of the k-th target, which a list comes down to."""
    under, over = costs.beside(k, TARGETS[k])
    cost, ratio = Interval(costs.middle[k], *interval(costs.drawn[:, k])), None
    if cheapest is not None:
        ratio = Interval(costs.middle[k] / cheapest.middle[k], *interval(costs.drawn[:, k] / cheapest.drawn[:, k]))
    return Reached(cost=cost, ratio=ratio, at=under, over=over)


def _unreached(points: Sequence[CostPoint], best: CostPoint, target: float) -> Beyond | Silent:
    """What is known of a target that no clocked point comes down to."""
    close = [point for point in points if point.error <= target]
    if not close:
        return Beyond(at=best, trend=foreseen(points, target))
    least = min(close, key=lambda point: point.cost.value)
    return Silent(verdict="not clocked", reason=f"roughly {least.cost.value:.2g} CPU s", at=least)


@once
def priced(store: Store) -> Prices:
    """Points and prices of a store, worked out once for all that ask: they take longer than what is made of them."""
    return Prices(store)


def unit_of(trials: pd.DataFrame) -> str:
    """What costs of these trials count: 'simulated second', or 'ray' and the like."""
    units = {str(unit) for unit in trials["unit"].dropna()}
    return PER_SECOND if units <= {"step"} else " or ".join(sorted(units))


def marked(points: Sequence[CostPoint]) -> set[str]:
    """The trials on the front of these points."""
    flags = on_front([p.error for p in points], [p.cost.value for p in points])
    return {point.trial for point, on in zip(points, flags, strict=True) if on}


def without(trials: pd.DataFrame, here: Sequence[CostPoint], engine: str) -> Silent:
    """Of an engine that has no clocked point."""
    if any(point.engine == engine for point in here):
        return Silent(verdict="not clocked", reason="no point near the front was clocked; see the trials' warnings")
    counts = trials.groupby(["status", "reason"]).size().sort_values(ascending=False)
    status, reason = counts.index[0]
    return Silent(verdict="no answer", reason=f"{status}: {reason}" if reason else str(status))


def interval(values: Floats) -> tuple[float, float]:
    """The 95 % interval of drawn values, those left out that did not reach the target."""
    finite = values[np.isfinite(values)]
    return interval_of_drawn(finite) if len(finite) else (math.nan, math.nan)


class Draws:
    """What prices would be had other samples been taken, the same for all engines of a case: a bootstrap in two levels, as much
    wider as few samples know too little of their spread.

    Processes are drawn first and blocks within each, since what a process was given (its place in memory) stays with all its
    blocks; the truth's error is drawn evenly within its bar, and moves all errors of the case alike.

    Source: A. C. Davison & D. V. Hinkley, Bootstrap Methods and their Application (1997), section 3.8.
    """

    def __init__(self, points: Sequence[CostPoint], samples: Mapping[str, Mapping[SampledBlock, float]]) -> None:
        keys = sorted({key for point in points for key in samples.get(point.trial, {})})
        places = drawn_in_groups(tuple(Counter(process for process, _ in keys).values()), DRAWS) if keys else None
        self._shift = _shifts()
        self._costs: dict[str, Floats] = {}
        for point in points:
            taken = samples.get(point.trial, {})
            values = np.array([*(taken.get(key, math.nan) for key in keys), math.nan])
            middle = medians(values[None, :])[0]
            drawn = medians(values[places]) / middle if taken and places is not None else np.ones(DRAWS)
            # A draw may hold none of this trial's samples: it then says nothing of its cost.
            drawn = np.where(np.isfinite(drawn), drawn, 1.0)
            self._costs[point.trial] = point.cost.value * drawn ** widening(len(taken))

    def of(self, points: Sequence[CostPoint], targets: Floats) -> Floats:
        """The prices of each draw for points that differ in the time step alone, shape (DRAWS, t)."""
        errors, offs = np.array([p.error for p in points]), np.array([p.off for p in points])
        costs = np.stack([self._costs[p.trial] for p in points], axis=1)
        shifted = np.maximum(errors[None, :] + self._shift[:, None] * offs[None, :], LEAST)
        return prices_of_draws(shifted, costs, targets)


@cache
def _shifts() -> Floats:
    """Where in the truth's bar each draw lies, shape (DRAWS,)."""
    return np.random.default_rng(0).uniform(-1.0, 1.0, DRAWS)


class List:
    """The prices of one engine in one case.

    Terms:
        best: its most accurate clocked point, None without one. middle: its prices, shape (t,), nan where it does not get
        there; drawn: those of each draw, shape (DRAWS, t).
    """

    def __init__(self, points: Sequence[CostPoint], draw: Draws, targets: Floats) -> None:
        clocked = [point for point in points if point.clocked]
        self.best = min(clocked, key=lambda p: p.error, default=None)
        self._groups = [[p for p in clocked if p.track == track] for track in dict.fromkeys(p.track for p in clocked)]
        none = np.full((1, len(targets)), math.nan)
        middles = [price(np.array([p.error for p in g]), np.array([p.cost.value for p in g]), targets) for g in self._groups]
        self._middles = np.stack(middles) if middles else none
        self.middle: Floats = np.fmin.reduce(self._middles)
        self._draw, self._targets = draw, targets

    @cached_property
    def drawn(self) -> Floats:
        """Worked out where it is asked for: a speed at a step that was run has no need of it."""
        if not self._groups:
            return self._middles
        least: Floats = np.fmin.reduce([self._draw.of(group, self._targets) for group in self._groups])
        return least

    def beside(self, k: int, target: float) -> tuple[CostPoint, CostPoint | None]:
        """The point that the k-th price leans on, and the next one of the same group that errs more than the target."""
        group = self._groups[int(np.nanargmin(self._middles[:, k]))]
        at = target * (1 + 1e-9)  # a price is one of logarithms, whose rounding may put an error at the target beyond it
        under = min((p for p in group if p.error <= at), key=lambda p: p.cost.value)
        return under, min((p for p in group if p.error > at), key=lambda p: p.error, default=None)
