"""The charts of errors: against the time step, and across cases; a trial that has no place on the axes stands at an edge."""

import math
from collections.abc import Iterable, Mapping, Sequence
from operator import itemgetter
from statistics import median
from typing import Any

import pandas as pd

from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, thin
from plumbline.reports.charts.grammar import Row, channel, chart, fixed
from plumbline.reports.charts.marks import (
    HOVER,
    LANE,
    NUMBERS,
    POINT,
    Marks,
    decades,
    finished,
    lane_names,
    lane_texts,
    logarithmic,
    ticks,
)
from plumbline.reports.tables.trial_results import answers
from plumbline.reports.words.catalogue import cases, labels, setting_words
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import amount, slug, step, unit_text, visible

STEP = "time step [ms]"


BY_STEP = "Down is more accurate, left is a finer step; the grey line is the bound of the check."
BY_STEP_HOW = (
    "Each point is one trial; a line joins the medians of trials that differ in the time step only, an upright bar spans "
    "their seeds. Trials without an error stand above the frame as their outcome; "
    "errors of exactly zero stand on its lower edge."
)


def error_by_step(
    store: Store,
    rows: pd.DataFrame,
    name: str,
    metric: str,
    unit: str,
    caption: str = BY_STEP,
    *,
    how: str = BY_STEP_HOW,
    bounded: bool = True,
) -> Figure | None:
    """Error against time step, both logarithmic; None where no trial has an error beyond 0.

    Args: bounded: have all engines one bound to draw?
    """
    drawn = points(store, rows)
    if not any(row["edge"] == "none" for row in drawn):
        return None
    bounds = sorted({(row["dt"], row["bound"]) for row in drawn if row["bound"]}) if bounded else []
    spec = layered(store, drawn, axis_title(metric, unit), bounds=bounds)
    return Figure(f"{name}-step", "Error against time step", caption, spec, *table(drawn, ("step", "error")), how)


def step_charts(store: Store) -> Mapping[str, str]:
    """By case the name of its `error_by_step`; a case on which no trial errs beyond 0 has none."""
    rows = answers(store)
    drawn = rows["case"][rows["error"] > 0].unique()
    return {str(name): f"case-{slug(str(name))}-step" for name in drawn}


def axis_title(metric: str, unit: str) -> str:
    """'position error [m]', at a length that leaves room for the chart; a number without a unit has none."""
    return visible(metric_title(metric))[:50] + ("" if unit == "1" else f" [{visible(unit_text(unit))[:12]}]")


def table(drawn: Iterable[Row], numbers: Sequence[str]) -> tuple[Sequence[str], Sequence[Sequence[Any]]]:
    """Headings and cells of the table under a chart."""
    columns = ("engine", "track", *(HOVER[name] for name in numbers), "outcome", "trial")
    keys = ("engine", "track", *numbers, "status", "trial")
    return columns, [[amount(row[key]) if key in NUMBERS else row[key] for key in keys] for row in drawn]


def layered(store: Store, drawn: list[Row], y_title: str, *, bounds: Sequence[Any]) -> Row:
    """Lines, ranges, points and edges over one pair of axes."""
    placed = [row for row in drawn if row["edge"] == "none"]
    placed = [row for line in grouped(placed, itemgetter("series")).values() for row in thin(line, "dt", "error")]
    style = Marks(store, drawn)
    x = logarithmic("dt", STEP, ticks(drawn, "dt"))
    y = logarithmic("error", y_title, decades(row["error"] for row in placed))
    marks = style.channels()
    layers: list[Any] = []
    if len(bounds) > 0:
        layers.append(bound_line(bounds, x, y))
    lines = medians(placed)
    layers.append(
        chart(lines)
        .marked("line", strokeWidth=1.6)
        .encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash())
    )
    if seeds := spans(placed):
        least = channel("least:Q", title=y_title)
        layers.append(chart(seeds).marked("rule", strokeWidth=1.4).encode(x=x, y=least, y2="most:Q", color=style.colour()))
    layers.append(chart(placed).marked("point", **POINT).encode(x=x, y=y, **marks))
    exact = [row for row in drawn if row["edge"] == "exact"]
    if exact:
        layers.append(chart(exact).marked("point", **POINT).encode(x=x, y=fixed("height"), **marks))
    return finished([*layers, *outcome_lanes(drawn, x, style)], height=320)


def bound_line(bounds: Sequence[tuple[float, float]], x: Any, y: Any) -> Any:
    """The bound of the check: a line over the time steps, or a short stroke where there is one step only."""
    steps = chart([{"dt": dt, "error": bound} for dt, bound in bounds])
    several = len({dt for dt, _ in bounds}) > 1
    grey: Row = {"color": "#8a93a0"}
    stroke: Row = {"orient": "horizontal", "size": 60, "thickness": 1.5}
    return (steps.marked("line", **grey, strokeWidth=1.5) if several else steps.marked("tick", **grey, **stroke)).encode(
        x=x, y=y
    )


def outcome_lanes(drawn: Sequence[Row], x: Any, style: Marks) -> list[Any]:
    """Trials without an error, above the frame: a lane for each engine and track, a symbol where the trial would stand."""
    silent = grouped((row for row in drawn if row["edge"] == "outcome"), itemgetter("engine", "track"))
    rows = [row | {"lane": -10 - LANE * lane} for lane, trials in enumerate(silent.values()) for row in trials]
    names = [{"lane": -10 - LANE * lane, "label": f"{engine}, {track}"} for lane, (engine, track) in enumerate(silent)]
    return [*lane_texts(rows, "symbol", x, style, style.tooltip()), *lane_names(names)]


def medians(placed: Iterable[Row]) -> list[Row]:
    """One point for each series and time step: medians over seeds."""
    return [
        seeds[0] | {"error": median(row["error"] for row in seeds)}
        for seeds in grouped(placed, itemgetter("series", "dt")).values()
    ]


def spans(placed: Iterable[Row]) -> list[Row]:
    """The range of the error over the seeds of one setting, where there are several."""
    return [
        seeds[0] | {"least": min(row["error"] for row in seeds), "most": max(row["error"] for row in seeds)}
        for seeds in grouped(placed, itemgetter("series", "dt")).values()
        if len(seeds) > 1
    ]


def across_cases(
    store: Store, rows: pd.DataFrame, field: str, name: str, title: str, caption: str, how: str = ""
) -> Figure | None:
    """One row a case, one mark an engine: the median of a column of its trials, on a logarithmic axis.

    Exact answers stand on the left edge; what has no number stands as its outcome right of the frame.
    """
    titles = {key: visible(case["title"])[:60] for key, case in cases(store).items()}
    drawn = points(store, rows)
    merged: list[Row] = []
    silent: list[Row] = []
    for (case, _, _), trials in grouped(drawn, itemgetter("case", "engine", "track")).items():
        label = titles[case] if list(titles.values()).count(titles[case]) == 1 else f"{titles[case]} ({visible(case)[:40]})"
        numbers = [row[field] for row in trials if row[field]]
        first = max(trials, key=lambda row: outcome(row["status"]).rank) | {"case": label}
        (merged if numbers else silent).append(first | ({field: median(numbers)} if numbers else {}))
    if not merged:
        return None
    style = Marks(store, drawn)
    labelled = list(dict.fromkeys(row["case"] for row in [*merged, *silent]))
    x = logarithmic(field, title, decades(row[field] for row in merged))
    axis = {"grid": True, "labelLimit": 200, "labelPadding": 11, "ticks": False}
    y = channel("case:N", title=None, scale={"domain": labelled}, axis=axis)
    layers = [chart(merged).marked("point", **POINT).encode(x=x, y=y, **style.channels())]
    if exact := [row for row in silent if row["edge"] == "exact" and field == "error"]:
        layers.append(chart(exact).marked("point", **POINT).encode(x=fixed(0), y=y, **style.channels()))
    beside = grouped((row for row in silent if not answered(row, field)), itemgetter("case")).values()
    if outcomes := [row | {"column": column} for of_case in beside for column, row in enumerate(of_case)]:
        edge = chart(outcomes).marked("text", fontSize=12, fontWeight=700, dx={"expr": "12 + 13 * datum.column"})
        shown: Row = {"text": channel("symbol:N"), "color": style.colour(), "tooltip": style.tooltip()}
        layers.append(edge.encode(x=fixed("width"), y=y, **shown))
    spec = finished(layers, height=30 + 22 * len(labelled))
    return Figure(name, title, caption, spec, *beside_each_other([*merged, *silent], style.engines, field), how)


def beside_each_other(rows: Sequence[Row], engines: Sequence[str], field: str) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Headings and cells of a table with a row for each case and track, a column for each engine: a number or an outcome."""
    sides = grouped(rows, itemgetter("case", "track"))
    cells = []
    for (case, track), mine in sides.items():
        by_engine = {row["engine"]: amount(row[field]) if row[field] is not None else row["status"] for row in mine}
        cells.append([case, track, *(by_engine.get(engine, "") for engine in engines)])
    return ("case", "track", *engines), cells


def answered(row: Row, field: str) -> bool:
    """Is a missing number no failure: an error of exactly zero, or a trial that was not timed though it answered?"""
    return bool(row["edge"] == "exact" or (field in ("cpu", "pace") and row["edge"] != "outcome"))


def number(value: Any) -> float | None:
    """A finite float, or None: JSON has no NaN."""
    return float(value) if pd.notna(value) and math.isfinite(value) else None


def points(store: Store, rows: pd.DataFrame) -> list[Row]:
    """Rows of `answers` for a chart.

    Terms of a row:
        engine, track, series, trial, status, symbol, reason, settings: words. dt [ms]; step: the same in words, with
        the sub-steps that it was taken in. error [its unit], cpu, low,
        high [CPU s per simulated s]; pace [simulated s per CPU s]. edge: 'none' where the error can be drawn on a
        logarithmic axis, 'exact' where it is
        0, 'outcome' where there is no error.
    """
    names = labels(store)
    drawn = []
    for row in records(rows):
        error, cpu = number(row["error"]), number(row["cpu_per_sim_s"])
        cpu = cpu if cpu is not None and cpu > 0 else None
        low, high = number(row["cpu_low"]), number(row["cpu_high"])
        drawn.append(
            {
                "engine": names[row["engine"]],
                "track": visible(setting_words(store, row["engine"], str(row["track"])))[:60],
                "series": row["series"],
                "trial": row["trial"],
                "case": row["case"],
                "status": outcome(row["status"]).name,
                "symbol": outcome(row["status"]).symbol,
                "reason": visible(str(row["said"]))[:300],
                "settings": visible(row["settings_line"])[:300],
                "dt": 1e3 * float(row["dt"]),
                "step": step(float(row["dt"]), substeps_of(str(row["resolved"]))),
                "error": error,
                "bound": number(row["at_most"]),
                "cpu": cpu,
                "pace": 1 / cpu if cpu is not None else None,
                "low": low if low is not None and low > 0 and cpu is not None else cpu,
                "high": high if high is not None and cpu is not None else cpu,
                "edge": "outcome" if error is None else "exact" if error == 0 else "none",
            }
        )
    return drawn
