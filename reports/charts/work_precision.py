"""Work against precision in one scene: the chart of every trial with an error and a cost, and its miniature of fronts alone.

Error against speed of each engine over the cases of a run: the picture of the first page.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.prices import LEAST, PER_SECOND
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled, thin
from plumbline.reports.charts.grammar import Row, channel, chart, fixed, hovering
from plumbline.reports.charts.marks import (
    LANE,
    POINT,
    TRACKS,
    Marks,
    decades,
    finished,
    lane_names,
    lane_texts,
    logarithmic,
    looks,
)
from plumbline.reports.tables.price_list import PricedScene, scenes
from plumbline.reports.tables.selection import answer
from plumbline.reports.words.catalogue import case_file, cases, engines, labels, setting_words, titled
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import TIMES, duration, power, step, visible

WIDE, HIGH = 200, 132
"""Of a miniature, in its own units; LEFT and BELOW leave room for the numbers of its axes, MARGIN for its marks."""
LEFT, BELOW, MARGIN = 34, 16, 6


def drawn(store: Store, point: CostPoint) -> Row:
    """A point for the chart."""
    cost, (low, high) = point.cost.value, point.cost.ends
    return {
        "engine": labels(store)[point.engine],
        "track": point.track if point.track in TRACKS else "other settings",
        "setting": visible(point.track)[:60],
        "step": step(point.dt, point.substeps),
        "error": point.error,
        "least": max(point.error - point.off, LEAST),
        "most": point.error + point.off,
        "off": point.off,
        "cost": cost,
        "low": low,
        "high": high,
        "pace": 1 / cost,
        "slow": 1 / high,
        "fast": 1 / low,
        "timing": "rough, not clocked" if not point.clocked else "unstable" if point.unstable else "clocked",
        "status": outcome(point.status).name,
        "trial": point.trial,
    }


def hover(unit: str) -> list[Any]:
    """What hovering over a point shows."""
    paced = (("pace", "times real time"),) if unit == PER_SECOND else ()
    errors = ("error", "error, of the scale"), ("off", "the truth may be off by")
    costs = ("cost", cost_title(unit)), ("low", "95 % from [s]"), ("high", "to [s]")
    return [
        *hovering(("engine:N", "engine"), ("setting:N", "setting"), ("step:N", "time step")),
        *(channel(f"{key}:Q", title=title, format=".3~g") for key, title in (*errors, *paced, *costs)),
        *hovering(("status:N", "outcome"), ("timing:N", "timing"), ("trial:N", "trial")),
    ]


def cost_title(unit: str) -> str:
    """The title of an axis of costs."""
    return "CPU time per simulated second [s]" if unit == PER_SECOND else f"CPU time per {visible(unit)[:30]} [s]"


def work_precision(store: Store, scene: PricedScene) -> Figure:
    """Speed, or a cost that is not per simulated second, over error; every trial is a point, or stands above the frame."""
    rows = [drawn(store, point) for point in scene.points]
    clocked = [row for row, point in zip(rows, scene.points, strict=True) if point.clocked]
    rough = [row for row, point in zip(rows, scene.points, strict=True) if not point.clocked]
    front = [row for row, point in zip(rows, scene.points, strict=True) if point.front]
    best = [row for row, point in zip(rows, scene.points, strict=True) if point.best]
    lanes = tallies(store, scene)
    style = Marks(store, [*rows, *lanes])
    style.tracks = [track for track in style.tracks if track]
    paced = scene.unit == PER_SECOND
    error, title_y = "error, as a share of the case's scale", "times real time" if paced else cost_title(scene.unit)
    up, below, above = ("pace", "slow", "fast") if paced else ("cost", "low", "high")
    x = logarithmic("error", error, decades(row["error"] for row in rows))
    y = logarithmic(up, title_y, decades(row[up] for row in rows))
    channels = style.channels(hover(scene.unit))
    bar: Row = {"strokeWidth": 1.3, "clip": True}
    layers = [
        chart(best).marked("point", filled=False, size=260, strokeWidth=5, opacity=0.35, stroke="#8a93a0").encode(x=x, y=y),
        chart(front).marked("line", strokeWidth=1.6).encode(x=x, y=y, detail="engine:N", color=style.colour()),
        chart(clocked)
        .marked("rule", **bar)
        .encode(x=x, y=channel(f"{below}:Q", title=title_y), y2=f"{above}:Q", color=style.colour()),
    ]
    if doubtful := [row for row in rows if row["off"] > 0]:
        least = channel("least:Q", title=error)
        layers.append(chart(doubtful).marked("rule", **bar).encode(x=least, x2="most:Q", y=y, color=style.colour()))
    layers.append(chart(thin(clocked, "error", up)).marked("point", **POINT | {"size": 55}).encode(x=x, y=y, **channels))
    if rough:
        faint = chart(thin(rough, "error", up)).marked("point", filled=False, size=22, strokeWidth=1.2, opacity=0.55)
        layers.append(faint.encode(x=x, y=y, **{k: channels[k] for k in ("color", "shape", "tooltip")}))
    tooltips = hovering("engine:N", "reason:N")
    layers += [*lane_texts(lanes, "text", fixed("width"), style, tooltips, align="right"), *lane_names(lanes)]
    half = {"tuned", "other settings"} <= set(style.tracks)
    caption = f"The {'upper' if paced else 'lower'} left corner is best: accurate and {'fast' if paced else 'cheap'}."
    how = (
        f"Each point is one trial, open for the vendor's defaults{', half filled for other settings' if half else ''}; lines "
        "join what no other setting of the same engine beats, grey rings what no setting of any engine beats. Upright bars are "
        "95 % intervals of the cost, level ones how far the truth itself may be off; errors below 10⁻⁹ stand there. Costs "
        "are CPU time, that of all sub-steps which an engine cuts a time step into: hovering tells both."
        + (" Small faint points were not clocked: their cost is a rough one." if rough else "")
        + (" Trials without an error or a cost are counted above the frame." if lanes else "")
    )
    costs = ("CPU time [s]=cost", "95 % from [s]=low", "to [s]=high")
    errors = ("error", "truth off by=off")
    table = tabled(rows, "engine", "setting", "time step=step", *errors, *costs, "timing", "outcome=status", "trial")
    title = f"{'Speed' if paced else 'Cost'} against error" + (f": {visible(scene.where)[:60]}" if scene.where else "")
    return Figure(scene.name, title, caption, finished(layers, height=340), *table, how)


def tallies(store: Store, scene: PricedScene) -> list[Row]:
    """For each engine with trials that have no place on the chart: how many there are of each outcome."""
    rows: list[Row] = []
    for engine, trials in scene.silent.groupby("engine", sort=False):
        counts = Counter(outcome(status).symbol for status in trials["status"])
        reasons = dict.fromkeys(
            f"{outcome(s).name}: {'no error or no cost' if outcome(s).answered else r}"
            for s, r in zip(trials["status"], trials["reason"], strict=True)
        )
        text = "  ".join(f"{symbol} {count}" if count > 1 else symbol for symbol, count in counts.items())
        name, lane, reason = labels(store)[str(engine)], -10 - LANE * len(rows), visible("; ".join(reasons))[:300]
        rows.append({"engine": name, "label": name, "track": "", "lane": lane, "text": text, "reason": reason})
    return rows


@dataclass(frozen=True, slots=True)
class FrontMiniature:
    """A small picture of the fronts of one scene, on axes that all of them share.

    Terms:
        lines: colour, path of the front, and its points, engine by engine. across, up: ticks as (place, words).
        silent: trials that are not on it.
    """

    title: str
    address: str
    note: str
    lines: Sequence[tuple[str, str, Sequence[tuple[float, float]]]]
    across: Sequence[tuple[float, str]]
    up: Sequence[tuple[float, str]]
    silent: int


def miniatures(store: Store) -> list[FrontMiniature]:
    """One for each scene, all on the same axes."""
    fronts = [(scene, [point for point in scene.points if point.front]) for scene in scenes(store)]
    costs = [math.log10(point.cost.value) for scene, front in fronts for point in front if scene.unit == PER_SECOND]
    errors = [math.log10(point.error) for _, front in fronts for point in front]
    low, high = span(costs or [0.0])
    fine, coarse = span([min(error, 0.0) for error in errors])

    def across(log: float) -> float:
        return round(LEFT + MARGIN + (WIDE - LEFT - 2 * MARGIN) * share(log, fine, coarse), 1)

    def up(log: float) -> float:
        return round(HIGH - BELOW - MARGIN - (HIGH - BELOW - 2 * MARGIN) * share(log, low, high), 1)

    # Up is faster: the logarithm of a pace is that of a cost the other way round.
    def paced(log: float) -> float:
        return round(HIGH - BELOW - MARGIN - (HIGH - BELOW - 2 * MARGIN) * share(-log, -high, -low), 1)

    every = 4 if coarse - fine > 4 else 2 if coarse - fine > 2 else 1
    x_ticks = [(across(exponent), power(exponent)) for exponent in range(coarse, fine - 1, -every)]
    exponents = [exponent for exponent in range(low, high + 1) if high - low < 4 or exponent % 3 == 0]
    speeds = [(paced(exponent), f"{power(-exponent)}{TIMES}") for exponent in exponents]
    durations = [(up(exponent), duration(10.0**exponent)) for exponent in exponents]
    heights = {True: (paced, speeds), False: (up, durations)}
    return [
        FrontMiniature(
            title=titled(store, scene.case, scene.where),
            address=f"{case_file(scene.case)}#{scene.name}",
            note="" if scene.unit == PER_SECOND else f"per {visible(scene.unit)[:30]}",
            lines=[
                line(places, colour)
                for colour, places in placed(store, front, across, heights[scene.unit == PER_SECOND][0]).items()
            ],
            across=x_ticks,
            up=heights[scene.unit == PER_SECOND][1],
            silent=len(scene.silent),
        )
        for scene, front in fronts
    ]


def span(logs: Sequence[float]) -> tuple[int, int]:
    """Whole powers of ten around logarithms, two at least."""
    low, high = math.floor(min(logs, default=0.0)), math.ceil(max(logs, default=0.0))
    return low, max(high, low + 1)


def share(log: float, low: int, high: int) -> float:
    """Where a logarithm lies between two; what lies beyond stands at the edge."""
    return min(max((log - low) / (high - low), 0.0), 1.0)


def placed(store: Store, front: Sequence[CostPoint], across: Any, up: Any) -> Mapping[str, list[tuple[float, float]]]:
    """The places of each engine's front, by its colour, from accurate to cheap."""
    fronts: dict[str, list[tuple[float, float]]] = {}
    colours = looks(engines(store))
    for point in sorted(front, key=lambda point: point.error):
        position = (across(math.log10(point.error)), up(math.log10(point.cost.value)))
        fronts.setdefault(colours[point.engine].colour, []).append(position)
    return fronts


def line(places: Sequence[tuple[float, float]], colour: str) -> tuple[str, str, Sequence[tuple[float, float]]]:
    """Colour, path and places."""
    return colour, "M" + "L".join(f"{x:g},{y:g}" for x, y in places), places


LEAST_DRAWN = 1e-6
"""Share of the scale: what errs less stands here, since a ratio of rounding errors says nothing."""
ERROR, SPEED = "error, as a share of the case's scale", "times real time"


def error_against_speed(store: Store) -> Figure | None:
    """A small mark for each engine and case, a large one at its figures over all; None where no engine has a speed."""
    evidence = answer(store).evidence
    rows: list[Row] = [
        {
            "engine": labels(store)[engine],
            "track": evidence.tracks[engine],
            "setting": visible(setting_words(store, engine, evidence.tracks[engine]))[:60],
            "case": visible(str(cases(store)[case]["title"]))[:60],
            "error": max(speed.error, LEAST_DRAWN),
            "pace": speed.times.value,
            "step": speed.step or "at the error asked for",
        }
        for (case, engine), speed in evidence.speeds.items()
        if engine in evidence.engines
    ]
    if not rows:
        return None
    over_all: list[Row] = []
    for engine in evidence.engines:
        error, pace = evidence.error(engine), evidence.speed(engine)
        if error is not None and pace is not None:
            mine = next(row for row in rows if row["engine"] == labels(store)[engine])
            over_all.append(mine | {"error": max(error, LEAST_DRAWN), "pace": pace, "case": "all cases", "step": ""})
    style = Marks(store, rows)
    x = logarithmic("error", ERROR, decades(row["error"] for row in rows))
    y = logarithmic("pace", SPEED, decades(row["pace"] for row in rows))
    shown = hovering("engine:N", "setting:N", "case:N", ("error:Q", ERROR, ".2~g"), ("pace:Q", SPEED, ".3~g"), "step:N")
    channels = style.channels(shown) | {"x": x, "y": y}
    layers = [
        chart([{"error": 0.01}]).marked("rule", strokeDash=[4, 4], color="#8a93a0").encode(x=x),
        chart(rows).marked("point", **POINT | {"size": 34, "opacity": 0.4}).encode(**channels),
        chart(over_all).marked("point", **POINT | {"size": 330}).encode(**channels),
    ]
    caption = "Up is faster, left is more accurate. Large: all cases together. Small: each case. Dashed: 1 % error."
    how = (
        "A speed is the one at 1 % error if steps on both sides of it were run, else that of the cheapest run that passes "
        "every check of its case. All together: the geometric mean of speeds over the cases in which the engines have "
        "one, and the median of errors. Errors below a millionth of the scale stand there."
    )
    table = tabled([*over_all, *rows], "engine", "setting", "case", "error", f"{SPEED}=pace", "speed taken=step")
    return Figure("error-and-speed", "Error against speed, all cases", caption, finished(layers, height=300), *table, how)
