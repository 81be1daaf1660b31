"""Charts of the page Trends: a price index over nights with its levels, fences, steps and new segments; and its miniature.

What is drawn of a case on an engine: its price as one index over the nights, its levels and steps, and other answers.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.readings import NightOf
from plumbline.harness.history.regressions import Trends
from plumbline.harness.history.steps import PriceStep, Series
from plumbline.harness.statistics.change_points import Level, levelled, levels
from plumbline.harness.store.rows import grouped
from plumbline.harness.trajectory import Floats
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, EngineLook, finished
from plumbline.reports.words.text import amount, plural, slug, visible


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


NEUTRAL = "#8a93a0"
"""Of fences and rules; no engine has this colour."""
WIDE, HIGH, LEFT, TOP, BOTTOM = 220.0, 88.0, 34.0, 6.0, 70.0
"""Of a miniature, in its own units: the frame lies between LEFT and WIDE, TOP and BOTTOM; ticks of answers below."""


def index_chart(
    panels: Sequence[TrendPanel], nights: Sequence[NightOf], looks: Mapping[str, EngineLook], title: str
) -> Figure | None:
    """The index of one panel, or of several, over the nights; None where none was clocked."""
    days = [_day(night.stamp) for night in nights]
    points: list[Row] = []
    stretches: list[Row] = []
    rules: list[Row] = []
    for panel in panels:
        for number in np.flatnonzero(np.isfinite(panel.index)).tolist():
            points.append(
                {"engine": panel.engine_title, "night": days[number], "index": float(panel.index[number]),
                 "version": visible(nights[number].versions.get(panel.engine, ""))}
            )  # fmt: skip
        for number, level in enumerate(panel.levels):
            ends = {"engine": panel.engine_title, "level": level.value, "low": level.low, "high": level.high, "stretch": number}
            # A level ends where the next begins, so that a step is upright.
            last = panel.levels[number + 1].first if number + 1 < len(panel.levels) else level.last
            stretches += [ends | {"night": days[level.first]}, ends | {"night": days[max(last, level.first)]}]
        rules += _rules(panel, nights, days)
    if not points:
        return None
    mine = {panel.engine_title: looks[panel.engine] for panel in panels if np.isfinite(panel.index).any()}
    names = list(mine)
    colour = channel("engine:N", title=None, scale={"domain": names, "range": [look.colour for look in mine.values()]},
                       legend=None if len(names) == 1 else {})  # fmt: skip
    shape = channel("engine:N", title=None, scale={"domain": names, "range": [look.path for look in mine.values()]},
                      legend=None if len(names) == 1 else {})  # fmt: skip
    x = channel(
        "night:T", title=None, axis={"format": "%d %b %y", "labelOverlap": "greedy", "tickCount": 6, "labelFlush": True}
    )
    inside = [row[key] for row in stretches for key in ("low", "high")] + [row["index"] for row in points]
    low, high = max(min(inside), 0.2), min(max(inside), 5.0)
    scale = {"type": "log", "domain": [low / 1.01, high * 1.01], "clamp": True, "nice": False}

    def y(field: str) -> Any:
        return channel(f"{field}:Q", title="price over its first level", scale=scale, axis={"format": ".3~g", "tickCount": 5})

    tooltip = hovering("engine:N", "version:N", ("night:T", "", "%d %b %Y %H:%M"), ("index:Q", "over the first level", ".4~g"))
    layers: list[Any] = []
    if len(panels) == 1:
        layers.append(chart(stretches).marked("area", opacity=0.22, color=NEUTRAL).encode(x=x, y=y("low"), y2="high:Q",
                                                                                     detail="stretch:N"))  # fmt: skip
    layers.append(chart(stretches).marked("line", strokeWidth=2).encode(x=x, y=y("level"), detail="stretch:N", color=colour))
    small = POINT | {"size": 26, "opacity": 0.75, "clip": True}
    layers.append(chart(points).marked("point", **small).encode(x=x, y=y("index"), color=colour, shape=shape, tooltip=tooltip))
    for kind, dashes in (("step", [1, 0]), ("segment", [3, 3])):
        drawn = [row for row in rules if row["kind"] == kind]
        if drawn:
            said = hovering(("what:N", kind), ("night:T", "", "%d %b %Y %H:%M"))
            line = chart(drawn).marked("rule", strokeDash=dashes, strokeWidth=1.4, color=NEUTRAL)
            layers.append(line.encode(x=x, tooltip=said))
    table = tabled(points, "engine", "night", "version", ("over the first level", lambda row: amount(row["index"], 4)))
    beside = "over other engines of the same nights" if panels[0].beside == "other engines" else "over the canary"
    fence = " Grey band: the fence, three spreads of its own from each level." if len(panels) == 1 else ""
    caption = f"Each mark is a night: the geometric mean of {plural(panels[0].series, 'price')}, {beside}."
    how = (
        f"Lines: levels; upright: a "
        f"change of level; dashed: another version or machine, across which nothing is compared.{fence}"
    )
    spec = finished(layers, height=210 if len(panels) == 1 else 260)
    name = slug(f"trend-{panels[0].case}-{'-'.join(panel.engine for panel in panels)}")
    return Figure(name, title, caption, spec, *table, how)


def _rules(panel: TrendPanel, nights: Sequence[NightOf], days: Sequence[str]) -> list[Row]:
    """Where the panel steps, and where its segments begin."""
    rows: list[Row] = [
        {"night": days[step.night], "kind": "step", "what": f"{panel.engine_title}: {amount(step.change.ratio)} times"}
        for step in panel.steps
    ]
    for before, now in _segment_starts(panel):
        version = nights[now].versions.get(panel.engine, "")
        other = version != nights[before].versions.get(panel.engine, "")
        what = f"{panel.engine_title} {version}" if other else nights[now].processor or "another machine"
        rows.append({"night": days[now], "kind": "segment", "what": visible(what)})
    return rows


def _segment_starts(panel: TrendPanel) -> list[tuple[int, int]]:
    there = np.flatnonzero(panel.segments >= 0).tolist()
    return [(a, b) for a, b in pairwise(there) if panel.segments[a] != panel.segments[b]]


def _day(stamp: str) -> str:
    return datetime.strptime(stamp, "%Y%m%dT%H%M%SZ").replace(tzinfo=UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendMiniature:
    """A panel of a few strokes. Terms: engine; colour; dots, levels: of the price; steps: upright lines, each with a class;
    segments: dashed ones; ticks: nights of other bits, each with its place and height; up: marks of the upright axis; words:
    what it says to who cannot see it."""

    engine: str
    colour: str
    dots: str
    levels: tuple[tuple[float, float, float], ...]
    steps: tuple[tuple[float, str], ...]
    segments: tuple[float, ...]
    ticks: tuple[tuple[float, float], ...]
    up: tuple[tuple[float, str], ...]
    words: str


def miniature(panel: TrendPanel, colour: str) -> TrendMiniature:
    """The same as `index_chart` in a few strokes; prices beyond twice or half of all levels stand on the edge."""
    count = len(panel.index)
    values = panel.index[np.isfinite(panel.index)]
    ends = [level.value for level in panel.levels] or [1.0]
    low = min(0.9 * min(ends), max(float(np.min(values, initial=1.0)), min(ends) / 2))
    high = max(1.1 * max(ends), min(float(np.max(values, initial=1.0)), 2 * max(ends)))

    def across(night: float) -> float:
        return round(LEFT + (WIDE - LEFT - 4) * (night + 0.5) / count, 1)

    def up(value: float) -> float:
        share = (math.log(min(max(value, low), high)) - math.log(low)) / (math.log(high) - math.log(low))
        return round(BOTTOM - (BOTTOM - TOP) * share, 1)

    dots = "".join(f"M{across(n)},{up(float(panel.index[n]))}h.01" for n in np.flatnonzero(np.isfinite(panel.index)).tolist())
    last = panel.levels[-1].value if panel.levels else math.nan
    words = (
        f"{panel.engine_title}: price now {amount(last)} times that of its first level, {len(panel.steps)} changes; "
        f"other bits on {len(panel.otherwise)} nights"
    )
    return TrendMiniature(
        engine=panel.engine_title,
        colour=colour,
        dots=dots,
        levels=tuple((across(x.first - 0.5), across(x.last + 0.5), up(x.value)) for x in panel.levels),
        steps=tuple((across(s.night - 0.5), "worse" if (s.change.ratio or 1.0) > 1 else "better") for s in panel.steps),
        segments=tuple(across(now - 0.5) for _, now in _segment_starts(panel)),
        ticks=tuple((across(night), round(3 + 9 * share / of, 1)) for night, share, of in panel.otherwise),
        up=tuple((up(value), amount(value, 2)) for value in (low, 1.0, high) if value == 1.0 or abs(math.log(value)) > 0.06),
        words=words,
    )
