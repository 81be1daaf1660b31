"""One small picture for each of the five answers on the page of a scene of one's own.

Each is drawn from what the charts further down show whole: who ran at which step, how far limits lie apart over time, what a
setting closes, speed over error, and how fast each engine is at the error asked for.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import shorten

from plumbline.harness.findings.agreement.costs import WITHIN, at_target, paced
from plumbline.harness.findings.agreement.found import errors_of, ways
from plumbline.harness.findings.agreement.setting_causes import CLOSES, Turned
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.agreement.words import share
from plumbline.harness.findings.columns import at
from plumbline.harness.findings.prices import Price
from plumbline.harness.store.store import Store
from plumbline.reports.charts.marks import EngineLook, looks, short
from plumbline.reports.charts.work_precision import FrontMiniature
from plumbline.reports.pictures.motion_chart import ChartSeries, Panel, over_time
from plumbline.reports.words.catalogue import engines, labels
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import TIMES, amount, power, step

WIDE, LEFT, RIGHT, ROW, TOP, FOOT = 360, 156, 258, 13, 6, 15
"""Of a picture, in its own units: its width, where its frame begins and ends, the height of a row, the room about the rows."""
MOST = 10
"""Rows of a picture."""
SETTING = 18
"""Letters of a setting's name that have room beside its engine."""
LEAST = 1e-6
"""Share of the size: what is less stands here."""
TURNS = 3
"""Settings that are shown of each engine and track, those that close most."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A mark in a row: where along it, and the symbol of an outcome, '' for the engine's own mark."""

    x: float
    symbol: str = ""


@dataclass(frozen=True, slots=True)
class Bar:
    """A row. Terms: ours: of the reference engine. y: of its middle. bar: how far it goes, None without. words: at its end."""

    label: str
    look: EngineLook
    hollow: bool
    ours: bool
    strong: bool
    y: float
    spots: tuple[Spot, ...]
    bar: float | None
    words: str


@dataclass(frozen=True, slots=True)
class BarRows:
    """Rows with marks or bars on one axis. Terms: ticks: along it, (place, words). limit: the place of a bound, None without.
    caption, alt: in words."""

    lines: tuple[Bar, ...]
    height: int
    ticks: tuple[tuple[float, str], ...]
    limit: float | None
    caption: str
    alt: str


@dataclass(frozen=True, slots=True)
class AnswerPicture:
    """The picture of an answer: exactly one of them is there. Terms: caption: of what is no `Rows`."""

    rows: BarRows | None = None
    panel: Panel | None = None
    fronts: FrontMiniature | None = None
    caption: str = ""


class _Sheet:
    """Rows that are begun one after the other."""

    def __init__(self, store: Store) -> None:
        self._named, self._labels = engines(store), labels(store)
        self._looks = looks(self._named)
        self.lines: list[Bar] = []

    def add(
        self, engine: str, track: str, *, what: str = "", spots: Sequence[Spot] = (), bar: float | None = None,
        words: str = "", strong: bool = False,
    ) -> None:  # fmt: skip
        """Add a row, if there is room for it. Args: what: is said in place of the track."""
        if len(self.lines) < MOST:
            label = f"{short(self._labels[engine])} {what or track}"
            ours = bool(self._named[engine]["ours"])
            y = TOP + ROW * (len(self.lines) + 0.5)
            line = Bar(label, self._looks[engine], track == "default", ours, strong, y, tuple(spots), bar, words)
            self.lines.append(line)

    def rows(
        self, caption: str, alt: str, ticks: Sequence[tuple[float, str]] = (), limit: float | None = None
    ) -> AnswerPicture | None:
        """The picture, None without a row."""
        if not self.lines:
            return None
        height = TOP + ROW * len(self.lines) + FOOT
        return AnswerPicture(rows=BarRows(tuple(self.lines), height, tuple(ticks), limit, caption, alt))


def _along(value: float, low: float, high: float) -> float:
    """Where a value lies on a logarithmic axis between two powers of ten."""
    share_of_axis = (math.log10(max(value, 10.0**low)) - low) / (high - low)
    return round(LEFT + (RIGHT - LEFT) * min(max(share_of_axis, 0.0), 1.0), 1)


def _axis(values: Sequence[float]) -> tuple[float, float, list[tuple[float, str]]]:
    """Powers of ten about values, one at least, and ticks at four of them at most."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)
    every = max(1, math.ceil((high - low) / 3))
    return low, high, [(_along(10.0**k, low, high), power(k)) for k in range(low, high + 1, every)]


def runs_by_step(store: Store, agreement: Agreement) -> AnswerPicture | None:
    """Who has an answer at which time step, and what became of runs without one."""
    steps = sorted({rung.dt for side in agreement.sides for rung in side.limit.rungs}, reverse=True)
    if not steps:
        return None
    room = WIDE - 40 - LEFT  # there are no words at the ends of rows
    places = {dt: round(LEFT + 10 + room * k / max(len(steps) - 1, 1), 1) for k, dt in enumerate(steps)}
    sheet = _Sheet(store)
    for side in agreement.sides:
        spots = [Spot(places[r.dt], "" if r.run is not None else outcome(r.status).symbol) for r in side.limit.rungs]
        sheet.add(side.engine, side.track, spots=spots)
    ends = [(places[dt], step(dt)) for dt in dict.fromkeys((steps[0], steps[-1]))]
    return sheet.rows(
        "A mark: an answer at that time step; another sign: none.",
        f"Answers at {len(steps)} time steps, engine by engine",
        ends,
    )


def distances(store: Store, agreement: Agreement, motion: Panel | None) -> AnswerPicture | None:
    """How far the limits of engines lie from the agreed one over time; where all are one, how they move."""
    base, series = ways(agreement)
    chosen = looks(engines(store))
    drawn = [
        ChartSeries(time, distance, chosen[engine].colour, track == "default")
        for (engine, track), (time, distance) in series.items()
    ]
    to = "the agreed limit" if not base else f"that of {base}"
    alt = f"Distance of each engine's limit from {to} over time"
    panel = over_time(drawn, agreement.bar, alt, width=WIDE, height=TOP + 8 * ROW + FOOT)
    if panel is not None:
        return AnswerPicture(panel=panel, caption=f"Distance from {to}, of the size; green: what it is known to.")
    return None if motion is None else AnswerPicture(panel=motion, caption=f"{motion.title}: all runs over one another.")


def causes(store: Store, agreement: Agreement, turned: Sequence[Turned]) -> AnswerPicture | None:
    """What turning a setting alone closes of a distance; where none was turned, how far each engine is off."""
    sheet = _Sheet(store)
    for engine, track in dict.fromkeys((each.engine, each.track) for each in turned):
        mine = [each for each in turned if (each.engine, each.track) == (engine, track) and each.closes is not None]
        for each in mine[:TURNS]:
            closes = each.closes or 0.0
            bar = round(LEFT + (RIGHT - LEFT) * min(max(closes, 0.0), 1.0), 1)
            what = shorten(each.setting.replace("_", " "), SETTING, placeholder=" …")
            sheet.add(engine, track, what=what, bar=bar, words=f"{100 * closes:.0f} %", strong=each.cause)
    if sheet.lines:
        ticks = [(LEFT + (RIGHT - LEFT) * mark, f"{100 * mark:.0f} %") for mark in (0.0, 0.5, 1.0)]
        caption = "Of the distance, what a setting closes that is turned alone; a cause closes 80 %."
        return sheet.rows(caption, "Distance that settings close, turned one by one", ticks, LEFT + (RIGHT - LEFT) * CLOSES)
    off = {(side.engine, side.track): _off(side) for side in agreement.sides}
    values = [max(value, LEAST) for value in off.values() if value is not None]
    if not values:
        return None
    low, high, ticks = _axis([*values, WITHIN])
    for (engine, track), value in off.items():
        if value is not None:
            sheet.add(engine, track, bar=_along(max(value, LEAST), low, high), words=share(value))
    caption = "How far off, of the size: from the agreed limit, else by what the last halving of the step moves."
    return sheet.rows(caption, "How far each engine is off", ticks, _along(WITHIN, low, high))


def _off(side: Side) -> float | None:
    moved = side.limit.moved
    return side.distance if side.distance is not None else None if moved is None else float(moved[-1])


def fronts(scenes: Sequence[FrontMiniature], cost: AnswerPicture | None) -> AnswerPicture | None:
    """Speed over error; where nothing was clocked, the least errors."""
    if not any(front.lines for front in scenes):
        return cost
    return AnswerPicture(fronts=next(front for front in scenes if front.lines), caption="Up is faster, left is more accurate.")


def speeds(store: Store, agreement: Agreement, best: Price | None) -> AnswerPicture | None:
    """How fast each engine is at the error asked for; where none comes down to it, how near each comes."""
    met = paced(at_target(store, agreement))
    if not met:
        return least_errors(store, agreement)
    paces = [1 / reached.cost.value for _, reached in met]
    low, high, ticks = _axis(paces)
    sheet = _Sheet(store)
    chosen = () if best is None else (best.engine, at(best, "reached.at.track"))
    for (price, reached), pace in zip(met, paces, strict=True):
        words, side = f"{amount(pace)}{TIMES}, {step(reached.at.dt)}", (price.engine, reached.at.track)
        sheet.add(*side, spots=[Spot(_along(pace, low, high))], words=words, strong=side == chosen)
    own = "" if agreement.agreed else " from its own limit, as none is agreed"
    caption = f"Times real time at {100 * WITHIN:g} % error{own}{'; bold: what to set' * (best is not None)}."
    return sheet.rows(caption, "Speed of each engine at that error", ticks)


def least_errors(store: Store, agreement: Agreement) -> AnswerPicture | None:
    """The smallest error of each engine and track, against the one asked for."""
    errors = errors_of(store)
    least: Mapping[tuple[str, str], float] = {
        (side.engine, side.track): max(min(mine), LEAST)
        for side in agreement.sides
        if (mine := [errors[rung.trial].error for rung in side.limit.rungs if rung.trial in errors])
    }
    if not least:
        return None
    low, high, ticks = _axis([*least.values(), WITHIN])
    sheet = _Sheet(store)
    for (engine, track), error in least.items():
        sheet.add(engine, track, spots=[Spot(_along(error, low, high))], words=share(error))
    caption = f"The smallest error of each, of the size; dashed: {100 * WITHIN:g} %."
    return sheet.rows(caption, "Smallest error of each engine", ticks, _along(WITHIN, low, high))
