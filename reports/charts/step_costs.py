"""The charts of what a step costs: its growth with the size of the scene, engine beside engine, and what the price buys.

The charts of many worlds: steps a second over their number, and error against throughput.
"""

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

from plumbline.harness.findings.parameter_words import axis_title
from plumbline.harness.findings.tables.scaling import TELLING, Cost, Scaling, Sweep, growth
from plumbline.harness.findings.tables.throughput import Throughput, bests
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, fixed, hovering
from plumbline.reports.charts.marks import POINT, Marks, at_values, decades, finished, logarithmic, short
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import labels, setting_words, titled
from plumbline.reports.words.text import visible

UNITS = WORDS["units"]
LANE = 15
"""Height of a line of text in a chart [px]."""
QUALITIES = 4
"""Scenes whose penetration is drawn: more would say the same again."""


def drawn(store: Store, row: Cost) -> Row:
    """A row for a chart, with the price in microseconds and penetration in micrometres."""
    assert row.cpu is not None
    low, high = row.cpu.ends
    return {
        "engine": labels(store)[row.engine],
        "track": "default" if row.track == "default" else "other settings",
        "setting": visible(setting_words(store, row.engine, row.track))[:60],
        "scene": titled(store, row.case, row.where),
        "cpu": 1e6 * row.cpu.value,
        "low": 1e6 * low,
        "high": 1e6 * high,
        "penetration": None if row.penetration is None else 1e6 * max(row.penetration, 1e-9),
        "residual": None if row.residual is None else 1e6 * row.residual,
        "status": row.status,
        "trial": row.trial,
        "best": row.best,
    }


def hover(*more: tuple[str, str]) -> list[Any]:
    """What hovering over a row shows."""
    words = [("engine", "engine"), ("setting", "setting"), ("scene", "scene"), ("status", "outcome")]
    numbers = [("cpu", "CPU time [µs]"), ("low", "95 % from"), ("high", "to"), *more]
    return [
        *(channel(f"{key}:N", title=title) for key, title in words),
        *(channel(f"{key}:Q", title=title, format=".4~g") for key, title in numbers),
        channel("trial:N", title="trial"),
    ]


def growths(store: Store, scaling: Scaling) -> list[Figure]:
    """One chart a sweep: the price over the parameter, a line through each engine's fastest settings."""
    return [growth_chart(store, sweep, index) for index, sweep in enumerate(scaling.sweeps)]


def growth_chart(store: Store, sweep: Sweep, index: int) -> Figure:
    """Price against the parameter of a sweep, both logarithmic."""
    rows = [drawn(store, row) | {"size": float(row.parameters[sweep.parameter])} for row in sweep.rows]
    style = Marks(store, rows)
    sizes = sorted({row["size"] for row in rows})
    across: Row = {"values": sizes, "format": ",~r", "labelOverlap": "greedy"}
    size = visible(axis_title(sweep.case, sweep.parameter))[:50]
    x = logarithmic("size", size, across)
    unit = UNITS.get(sweep.unit, sweep.unit)
    y = logarithmic("cpu", f"CPU time per {unit} [µs]", decades(row["cpu"] for row in rows))
    best = [row for row in rows if row["best"]]
    slopes: list[Row] = []
    for engine in dict.fromkeys(row.engine for row in sweep.rows):
        mine = [row for row in sweep.rows if row.engine == engine and row.best]
        fit = growth(sweep, mine) if mine else None
        if fit is not None and fit.telling:
            label = f"{short(labels(store)[engine])}: exponent {fit.fit.order:.2f}"
            slopes.append(drawn(store, mine[-1]) | {"label": visible(label), "lane": 14 + LANE * len(slopes)})
    channels = style.channels(hover(("size", size)))
    layers = [
        chart(best).marked("line", strokeWidth=1.6).encode(x=x, y=y, detail="engine:N", color=style.colour()),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    if slopes:
        # Beside the lines the labels of engines that are equally fast would cover each other.
        lane = channel("lane:Q", scale=None, axis=None)
        text = chart(slopes).marked("text", align="left", baseline="middle", fontSize=11, fontWeight=600)
        layers.append(text.encode(x=fixed(12), y=lane, text="label:N", color=style.colour()))
    caption = "Down is cheaper."
    if slopes:
        caption += " In the corner the exponent of a line that tells one: 1 means that twice the size cost twice the time."
    how = (
        "Each point is one engine under one group of settings, open for the vendor's defaults; the line joins the fastest "
        "setting whose checks hold. What did not finish has no point; the table says why. An exponent whose 95 % interval is "
        f"wider than {TELLING:g} is not stated: linear and quadratic growth are not told apart by it."
    )
    title = f"Price of a {unit}: {titled(store, sweep.case, sweep.where)}"
    costs = ("CPU time [µs]=cpu", "95 % from=low", "to=high")
    sized = (size, lambda row: f"{row['size']:g}")
    table = tabled(rows, sized, "engine", "setting", *costs, "outcome=status", "trial")
    return Figure(f"growth-{index}", title, caption, finished(layers, height=340), *table, how)


def standings(store: Store, scaling: Scaling) -> Figure | None:
    """Each engine's fastest setting in every scene, as a multiple of the fastest that people can deploy."""
    rows = [
        drawn(store, row) | {"times": row.to_fastest.value, "times_low": row.to_fastest.low, "times_high": row.to_fastest.high}
        for row in scaling.costs
        if row.best and row.cpu is not None and row.to_fastest is not None
    ]
    if not rows:
        return None
    style = Marks(store, rows)
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    x = logarithmic("times", "times the CPU time of the fastest", decades(row["times"] for row in rows))
    # A scene on two lines, its title and what sets it apart, leaves room for the marks on a phone.
    comma = "indexof(datum.label, ', ')"
    lines = f"{comma} < 0 ? datum.label : [slice(datum.label, 0, {comma}), slice(datum.label, {comma} + 2)]"
    axis = {"grid": True, "labelLimit": 150, "ticks": False, "labelExpr": lines}
    y = channel("scene:N", title=None, scale={"domain": scenes}, axis=axis)
    channels = style.channels(hover(("times", "over the fastest")))
    low = channel("times_low:Q")
    layers = [
        chart(rows).marked("rule", strokeWidth=1.4).encode(x=low, x2="times_high:Q", y=y, color=style.colour()),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    caption = "CPU time over that of the scene's fastest engine that can be deployed."
    how = (
        "Every engine at its own fastest setting among those that pass the scene's checks; the reference engine stands beside, "
        "below 1 where it takes less. "
        "Bars are 95 % intervals of the ratio within blocks. Penetration is not the same at these settings: "
        "the charts below and the table show what each price buys."
    )
    numbers = ("over the fastest=times", "95 % from=times_low", "to=times_high", "CPU time [µs]=cpu")
    spec = finished(layers, height=30 + 34 * len(scenes))
    table = tabled(rows, "scene", "engine", "setting", *numbers)
    return Figure("standings", "Fastest settings, scene by scene", caption, spec, *table, how)


def qualities(store: Store, scaling: Scaling) -> list[Figure]:
    """Penetration against price, for the scenes in which most engines and settings have both."""
    both = (row for row in scaling.costs if row.cpu is not None and row.penetration is not None and not row.beside)
    scenes = grouped(both, attrgetter("case", "where"))
    several = {scene: rows for scene, rows in scenes.items() if len({row.engine for row in rows}) > 1}
    richest = sorted(several, key=lambda scene: -len({row.engine for row in several[scene]}) * 1000 - len(several[scene]))
    chosen = [scene for scene in several if scene in richest[:QUALITIES]]
    return [quality_chart(store, several[scene], index) for index, scene in enumerate(chosen)]


def quality_chart(store: Store, costs: Sequence[Cost], index: int) -> Figure:
    """Penetration against price in one scene, both logarithmic."""
    rows = [drawn(store, row) for row in costs]
    style = Marks(store, rows)
    unit = UNITS.get(costs[0].unit, costs[0].unit)
    x = logarithmic("cpu", f"CPU time per {unit} [µs]", decades(row["cpu"] for row in rows))
    y = logarithmic("penetration", "penetration [µm]", decades(row["penetration"] for row in rows))
    channels = style.channels(hover(("penetration", "penetration [µm]"), ("residual", "moves [µm/s]")))
    low = channel("low:Q", title=f"CPU time per {unit} [µs]")
    layers = [
        chart(rows).marked("rule", strokeWidth=1.4).encode(x=low, x2="high:Q", y=y, color=style.colour()),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    caption = "The lower left corner is best: cheap, and no body stands in another."
    how = "Each point is one group of settings, open for the vendor's defaults; hovering names it, with what still moves."
    title = f"What the price buys: {rows[0]['scene']}"
    numbers = ("CPU time [µs]=cpu", "penetration [µm]=penetration", "residual motion [µm/s]=residual")
    table = tabled(rows, "engine", "setting", *numbers, "outcome=status", "trial")
    return Figure(f"quality-{index}", title, caption, finished(layers, height=300), *table, how)


LEAST = 1e-9
"""An error below this [m] is drawn as this: there is no logarithm of none."""
HEIGHT = 320
"""Of a chart [px]."""
_HOVER = (
    ("engine:N", "engine"),
    ("setting:N", "setting"),
    ("worlds:Q", "worlds"),
    ("rate:Q", "steps a second", ".4~s"),
    ("pace:Q", "times real time", ".4~g"),
    ("error:Q", "error [m]", ".3~g"),
    ("status:N", "outcome"),
    ("trial:N", "trial"),
)


def _drawn(store: Store, row: Throughput) -> Row:
    assert row.rate is not None
    assert row.pace is not None
    return {
        "engine": labels(store)[row.engine],
        "track": row.track,
        "setting": visible(setting_words(store, row.engine, row.track))[:60],
        "worlds": row.worlds,
        "dt": row.dt,
        "rate": row.rate.value,
        "low": row.rate.ends[0],
        "high": row.rate.ends[1],
        "pace": row.pace,
        "error": None if row.error is None else max(row.error, LEAST),
        "status": row.status,
        "trial": row.trial,
    }


def charts(store: Store, rows: Sequence[Throughput]) -> list[Figure]:
    """Two for each scene: what batching gives, and what speed costs in error."""
    figures = []
    for number, ((case, where), group) in enumerate(grouped(rows, attrgetter("case", "where")).items()):
        clocked = [row for row in group if row.rate is not None]
        scene = titled(store, case, where)
        if len({row.worlds for row in clocked}) > 1:
            figures.append(_batching(scene, store, clocked, number))
        if any(row.error is not None for row in clocked):
            figures.append(_bought(scene, store, [row for row in bests(clocked) if row.error is not None], number))
    return figures


def _batching(scene: str, store: Store, clocked: Sequence[Throughput], number: int) -> Figure:
    rows = [_drawn(store, row) for row in clocked]
    style = Marks(store, rows)
    x = logarithmic("worlds", "worlds stepped together", at_values(row["worlds"] for row in rows))
    y = logarithmic("rate", "steps of a world in a second of CPU time", decades(row["rate"] for row in rows))
    line = {
        "detail": [channel("engine:N"), channel("track:N"), channel("dt:N")],
        "color": style.colour(),
        "strokeDash": style.dash(),
    }
    channels = style.channels(hovering(*_HOVER))
    layers = [
        chart(rows).marked("line", strokeWidth=1.6).encode(x=x, y=y, **line),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    rates = ("steps a second=rate", "95 % from=low", "to=high")
    table = tabled(rows, "engine", "setting", "worlds", *rates, "outcome=status", "trial")
    caption = "Up is faster; a line that rises is an engine that gains by stepping worlds together."
    how = (
        "One thread. Each point is one engine under one group of settings, open for the vendor's defaults. An engine without a "
        "batch of its own has its worlds stepped in turn, four steps each: its line stays level, or falls where worlds no "
        "longer fit the processor's caches."
    )
    return Figure(f"batching-{number}", f"Steps a second: {scene}", caption, finished(layers, HEIGHT), *table, how)


def _bought(scene: str, store: Store, best: Sequence[Throughput], number: int) -> Figure:
    rows = [_drawn(store, row) for row in sorted(best, key=lambda row: row.pace or 0.0)]
    style = Marks(store, rows)
    x = logarithmic("pace", "simulated seconds of a world in a second of CPU time", decades(row["pace"] for row in rows))
    y = logarithmic("error", "error at the end [m]", decades(row["error"] for row in rows))
    channels = style.channels(hovering(*_HOVER))
    line = {"detail": channel("engine:N"), "color": style.colour(), "order": channel("pace:Q")}
    layers = [
        chart(rows).marked("line", strokeWidth=1.2, opacity=0.6).encode(x=x, y=y, **line),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    numbers = ("time step [s]=dt", "worlds", "times real time=pace", "error [m]=error")
    table = tabled(rows, "engine", "setting", *numbers, "outcome=status", "trial")
    caption = "The lower right corner is best: fast, and right at the end. One line an engine, through its settings and steps."
    how = (
        "Each setting stands at the number of worlds at which it is fastest. The error is the distance of the worst body from "
        "where it has to be at the end, of the same settings at the same step."
    )
    return Figure(f"bought-{number}", f"Error against throughput: {scene}", caption, finished(layers, HEIGHT), *table, how)
