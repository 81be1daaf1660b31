"""Prices that changed for good: of an engine as a whole, of a case on it, or of one series, each step told once.

What moves together is judged together: series of one case on one engine as one of less noise, and their medians as the engine.
A step counts for the group where most of its members take it; it is then taken out of them before they are judged alone.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.normalisation import over_segments
from plumbline.harness.history.series import Series
from plumbline.harness.statistics.change_points import FEWEST, ChangePoint, change_points, common_mode, levelled
from plumbline.harness.trajectory import Floats

CHANCE_OF_ALL = 1e-3
"""Of a history: how often chance alone may look like a change in any of its series; each has its share."""
FEWEST_CASES = 3
"""Whose median is an engine."""
MOST = 0.6
"""Share of a group's members that take its step, to at least half of it."""
Z_95 = 1.96


@dataclass(frozen=True, slots=True)
class PriceStep:
    """Terms: night: index of the first on the new level. change: what is told of it. members: the series that took it."""

    night: int
    change: Change
    members: tuple[Series, ...]


def price_steps(series: Sequence[Series], chance: float = CHANCE_OF_ALL) -> Iterator[PriceStep]:
    """Every step of the prices among the series, engine by engine. Args: chance: of a history, see `CHANCE_OF_ALL`."""
    prices = [one for one in series if one.subject.kind == "price"]
    engines: dict[str, dict[tuple[str, str], list[Series]]] = {}
    for one in prices:
        engines.setdefault(one.subject.engine, {}).setdefault((one.subject.case, one.subject.metric), []).append(one)
    groups = [group for cases in engines.values() for group in cases.values()]
    together = sum(len(group) > 1 for group in groups) + sum(len(cases) >= FEWEST_CASES for cases in engines.values())
    for cases in engines.values():
        yield from _of_engine(list(cases.values()), chance / max(len(prices) + together, 1))


def _of_engine(groups: Sequence[Sequence[Series]], chance: float) -> Iterator[PriceStep]:
    members = tuple(one for group in groups for one in group)
    segments = np.max([one.segments for one in members], axis=0)
    rows = [np.array([over_segments(one.free, one.segments) for one in group]) for group in groups]
    taken = np.ones(len(segments))
    if len(groups) >= FEWEST_CASES:
        by_case = np.array([levelled(group) for group in rows])
        whole = np.where(np.isfinite(by_case).any(axis=0), common_mode(by_case), np.nan)
        points = _shared(change_points(whole, segments, chance), by_case, segments)
        taken = _staircase(points, segments)
        for point in points:
            yield PriceStep(point.index, _change(point, members, whole=True), members)
    for group, values in zip(groups, rows, strict=True):
        yield from _of_case(group, values / taken, segments, chance)


def _of_case(group: Sequence[Series], rows: Floats, segments: NDArray[np.int64], chance: float) -> Iterator[PriceStep]:
    taken = np.ones(len(segments))
    if len(group) > 1:
        points = _shared(change_points(levelled(rows), segments, chance), rows, segments)
        taken = _staircase(points, segments)
        for point in points:
            yield PriceStep(point.index, _change(point, group, whole=False), tuple(group))
    for one, row in zip(group, rows, strict=True):
        for point in change_points(row / taken, one.segments, chance):
            yield PriceStep(point.index, _change(point, (one,), whole=False), (one,))


def _shared(points: Sequence[ChangePoint], rows: Floats, segments: NDArray[np.int64]) -> list[ChangePoint]:
    """The points that most of the rows (s, n) take."""
    kept = []
    ends = [point.index for point in points]
    for point in points:
        same = segments == segments[point.index]
        before = same & (np.arange(len(segments)) < point.index)
        before[: max([end for end in ends if end < point.index], default=0)] = False
        after = same & (np.arange(len(segments)) >= point.index)
        after[min([end for end in ends if end > point.index], default=len(segments)) :] = False
        steps = [_step(row, before, after) for row in rows]
        half = math.log(point.ratio) / 2
        took = [step / half >= 1 for step in steps if not math.isnan(step)]
        if took and sum(took) >= MOST * len(took):
            kept.append(point)
    return kept


def _step(row: Floats, before: NDArray[np.bool_], after: NDArray[np.bool_]) -> float:
    """The step of logarithms between medians; NaN where a side has too few nights."""
    logs = [np.log(row[side & np.isfinite(row)]) for side in (before, after)]
    return float(np.median(logs[1]) - np.median(logs[0])) if min(map(len, logs)) >= FEWEST else math.nan


def _staircase(points: Sequence[ChangePoint], segments: NDArray[np.int64]) -> Floats:
    """What the points multiply each night by (n,)."""
    factor = np.ones(len(segments))
    for point in points:
        factor[(segments == segments[point.index]) & (np.arange(len(segments)) >= point.index)] *= point.ratio
    return factor


def _change(point: ChangePoint, members: Sequence[Series], *, whole: bool) -> Change:
    first, alone = members[0].subject, len(members) == 1
    sides = [_at(members[0], point.index, later) for later in (False, True)] if alone else [None, None]
    beside: Beside = "other engines" if all(one.beside == "other engines" for one in members) else "canary"
    return Change(
        kind="price",
        sense="worse" if point.ratio > 1 else "better",
        case="" if whole else first.case,
        engine=first.engine,
        track=first.track if alone else "",
        where=first.where if alone else "",
        dt=first.dt if alone else 0.0,
        metric="CPU time" if whole else first.metric,
        unit="s" if alone else "1",
        trial_b=next(filter(None, members[0].trials[point.index :]), "") if alone else "",
        before=sides[0],
        after=sides[1],
        ratio=point.ratio,
        low=point.ratio * math.exp(-Z_95 * point.error),
        high=point.ratio * math.exp(Z_95 * point.error),
        beside=beside,
        count=len(members),
    )


def _at(series: Series, night: int, later: bool) -> float | None:
    """The median of the values [s] on one side of a night, within its segment."""
    same = (series.segments == series.segments[night]) & np.isfinite(series.values)
    side = same & ((np.arange(len(same)) >= night) == later)
    return float(np.median(series.values[side])) if side.any() else None
