"""How fast an engine is at an error: one rule, for selection and for pages.

The speed at the error asked for is known if steps were run on both sides of it. Otherwise it is the speed of one run, which is
said to be that run's: of the cheapest that passes every check of its case or errs no more than asked; without one, of the most
accurate, if it errs less than ten times as much. No bound stands for a value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import step_in_words
from plumbline.harness.findings.prices import PER_SECOND, Draws, List, interval, priced, unit_of
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store

Side = tuple[str, str, str]
"""A case, an engine and a track of it."""


BEYOND = 10.0
"""Times the error asked for, from which on a run is of no use."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Speed:
    """How fast one engine is on one track in one case, in the slowest of the case's scenes.

    Terms: times [1]: simulated over CPU seconds with the 95 % interval. error: at that speed, a share of the case's scale. at:
    the run that the figures lean on; over: the next one, which errs more than asked: they are those of the error asked for,
    between both. None where they are those of `at` alone. bound: does that run err no more than asked, so that larger steps,
    which were not run, might be faster? nominal: was it run at the case's own step?
    """

    times: Interval
    error: float
    at: CostPoint
    over: CostPoint | None
    bound: bool
    nominal: bool

    @property
    def at_error(self) -> bool:
        """Is it the speed at the error asked for, between two steps that were run?"""
        return self.over is not None

    @property
    def unstable(self) -> bool:
        """Was the timing of a run that it leans on marked so?"""
        return self.at.unstable or (self.over is not None and self.over.unstable)

    @property
    def step(self) -> str:
        """'at its nominal step', 'at dt = 2 ms'; '' if the figures are those of the error asked for."""
        if self.at_error:
            return ""
        return "at its nominal step" if self.nominal else f"at dt = {step_in_words(self.at.dt, self.at.substeps)}"

    @property
    def words(self) -> str:
        """'31 times real time at its nominal step'."""
        return f"{float(f'{self.times.value:.3g}'):g} times real time {self.step}".rstrip()


@once
def speeds(store: Store, error: float) -> Mapping[Side, Speed]:
    """By case, engine and track, in cases whose costs are those of steps; a side has none if one of its scenes has none."""
    prices, sound = priced(store), _sound(store)
    by_side: dict[Side, Speed | None] = {}
    for case, where, trials in prices.groups():
        if unit_of(trials) != PER_SECOND:
            continue
        own = float(store.catalogue.get("cases", {}).get(case, {}).get("dt") or 0.0)
        clocked = (point for point in prices.by_scene.get((case, where), ()) if point.clocked)
        for (engine, track), points in grouped(clocked, attrgetter("engine", "track")).items():
            side = (case, engine, track)
            speed = _speed([point for point in points if point.trial in sound], prices.draws(case, where), error, own)
            slowest = by_side.get(side, speed)
            by_side[side] = (
                None if speed is None or slowest is None else min(speed, slowest, key=lambda speed: speed.times.value)
            )
    return {side: speed for side, speed in by_side.items() if speed is not None}


def _sound(store: Store) -> frozenset[str]:
    """The trials with an answer that fails no check but that of the case's error, which the error asked for stands in for."""
    answered = store.asked[store.asked["status"].isin(("passed", "failed"))]
    headlines = {name: about.get("headline") for name, about in store.catalogue.get("cases", {}).items()}
    headline = dict(zip(answered["trial"], answered["case"].map(headlines), strict=True))
    failed = store.measurements[store.measurements["passed"].eq(False).fillna(False)]
    missed: dict[str, set[str]] = {}
    for trial, metric in zip(failed["trial"], failed["metric"], strict=True):
        missed.setdefault(trial, set()).add(metric)
    passed = dict(zip(answered["trial"], answered["status"] == "passed", strict=True))
    return frozenset(t for t, whole in passed.items() if whole or missed.get(t, set()) == {headline[t]})


def _speed(points: Sequence[CostPoint], draw: Draws, error: float, own: float) -> Speed | None:
    """Of sound clocked points of one track in one scene. Args: own: the case's time step [s]."""
    costs = List(points, draw, np.array([error]))
    close = np.isfinite(costs.middle[0])
    under, over = costs.beside(0, error) if close else (None, None)
    if over is None:
        good = [point for point in points if point.status == "passed" or point.error <= error]
        near = [point for point in points if point.error < BEYOND * error]
        under = min(good, key=lambda point: point.cost.value, default=min(near, key=lambda point: point.error, default=None))
    if under is None:
        return None
    cost, (low, high) = under.cost.value, under.cost.ends
    if over is not None:
        cost, (low, high) = float(costs.middle[0]), interval(costs.drawn[:, 0])
    return Speed(
        times=Interval(1 / cost, 1 / high, 1 / low),
        error=error if over is not None else under.error,
        at=under,
        over=over,
        bound=over is None and under.error <= error,
        nominal=bool(own) and abs(under.dt - own) <= 1e-9 * own,
    )
