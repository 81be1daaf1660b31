"""What is drawn of a case on an engine: its price as one index over the nights, its levels and steps, and other answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.regressions import Trends
from plumbline.harness.history.series import Series
from plumbline.harness.history.steps import PriceStep
from plumbline.harness.statistics.change_points import Level, levelled, levels
from plumbline.harness.store.rows import grouped
from plumbline.harness.trajectory import Floats


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TrendPanel:
    """A panel.

    Terms: case: '' for the engine as a whole. case_title, engine_title: what they are called. index (n,): the price over its
    first level, NaN where it was not clocked. segments (n,). levels: of the index, one for each stretch between steps and
    segments. steps: those that it took. beside: what prices were divided by. series: how many prices it is made of. otherwise:
    nights whose answers have other bits, each with the series that do: (night, how many, of how many).
    """

    case: str
    engine: str
    case_title: str
    engine_title: str
    index: Floats
    segments: NDArray[np.int64]
    levels: tuple[Level, ...]
    steps: tuple[PriceStep, ...]
    beside: Beside
    series: int
    otherwise: tuple[tuple[int, int, int], ...]


def panels(trends: Trends) -> tuple[TrendPanel, ...]:
    """One for each case on each engine that was clocked or has an error, in the order in which they were first seen."""
    cells = grouped(trends.series, attrgetter("case", "engine"))
    return tuple(_panel(case, engine, group, trends) for (case, engine), group in cells.items())


def engine_panels(trends: Trends) -> tuple[TrendPanel, ...]:
    """One for each engine as a whole."""
    engines = grouped(trends.series, attrgetter("engine"))
    return tuple(_panel("", engine, group, trends) for engine, group in engines.items())


def _panel(case: str, engine: str, group: Sequence[Series], trends: Trends) -> TrendPanel:
    count = len(trends.nights)
    prices = [one for one in group if one.kind == "price"]
    mine = {id(one) for one in prices}
    steps = tuple(
        step
        for step in trends.steps
        if (not case and not step.change.case and step.change.engine == engine)
        or (case and any(id(one) in mine for one in step.members))
    )
    values = levelled(np.array([one.free for one in prices])) if prices else np.full(count, np.nan)
    segments = np.max([one.segments for one in prices], axis=0) if prices else np.full(count, -1, np.int64)
    drawn = levels(values, {step.night for step in steps}, segments)
    first = drawn[0].value if drawn else 1.0
    return TrendPanel(
        case=case,
        engine=engine,
        case_title=trends.called(case) if case else "All cases",
        engine_title=trends.called(engine),
        index=values / first,
        segments=segments,
        levels=tuple(
            Level(first=x.first, last=x.last, value=x.value / first, low=x.low / first, high=x.high / first) for x in drawn
        ),
        steps=steps,
        beside=prices[0].beside if prices else "",
        series=len(prices),
        otherwise=_otherwise([one for one in group if one.kind == "error"], count),
    )


def _otherwise(errors: Sequence[Series], count: int) -> tuple[tuple[int, int, int], ...]:
    """Nights on which hashes differ from those before."""
    made = []
    last = [""] * len(errors)
    for night in range(count):
        others = 0
        for k, one in enumerate(errors):
            if one.hashes[night]:
                others += last[k] not in ("", one.hashes[night])
                last[k] = one.hashes[night]
        if others:
            made.append((night, others, len(errors)))
    return tuple(made)
