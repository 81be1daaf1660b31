"""The charts of many worlds: steps a second over their number, and error against throughput."""

from collections.abc import Sequence
from operator import attrgetter

from plumbline.harness.findings.tables.throughput import Throughput, bests
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, Marks, at_values, decades, finished, logarithmic
from plumbline.reports.words.catalogue import labels, setting_words, titled
from plumbline.reports.words.text import amount, visible

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
    channels = style.channels() | {"tooltip": hovering(*_HOVER)}
    layers = [
        chart(rows).marked("line", strokeWidth=1.6).encode(x=x, y=y, **line),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    columns = ("engine", "setting", "worlds", "steps a second", "95 % from", "to", "outcome", "trial")
    cells = [
        [r["engine"], r["setting"], r["worlds"], *(amount(r[k]) for k in ("rate", "low", "high")), r["status"], r["trial"]]
        for r in rows
    ]
    caption = "Up is faster; a line that rises is an engine that gains by stepping worlds together."
    how = (
        "One thread. Each point is one engine under one group of settings, open for the vendor's defaults. An engine without a "
        "batch of its own has its worlds stepped in turn, four steps each: its line stays level, or falls where worlds no "
        "longer fit the processor's caches."
    )
    return Figure(f"batching-{number}", f"Steps a second: {scene}", caption, finished(layers, HEIGHT), columns, cells, how)


def _bought(scene: str, store: Store, best: Sequence[Throughput], number: int) -> Figure:
    rows = [_drawn(store, row) for row in sorted(best, key=lambda row: row.pace or 0.0)]
    style = Marks(store, rows)
    x = logarithmic("pace", "simulated seconds of a world in a second of CPU time", decades(row["pace"] for row in rows))
    y = logarithmic("error", "error at the end [m]", decades(row["error"] for row in rows))
    channels = style.channels() | {"tooltip": hovering(*_HOVER)}
    line = {"detail": channel("engine:N"), "color": style.colour(), "order": channel("pace:Q")}
    layers = [
        chart(rows).marked("line", strokeWidth=1.2, opacity=0.6).encode(x=x, y=y, **line),
        chart(rows).marked("point", **POINT).encode(x=x, y=y, **channels),
    ]
    columns = ("engine", "setting", "time step [s]", "worlds", "times real time", "error [m]", "outcome", "trial")
    cells = [
        [
            r["engine"],
            r["setting"],
            amount(r["dt"]),
            r["worlds"],
            amount(r["pace"]),
            amount(r["error"]),
            r["status"],
            r["trial"],
        ]
        for r in rows
    ]
    caption = "The lower right corner is best: fast, and right at the end. One line an engine, through its settings and steps."
    how = (
        "Each setting stands at the number of worlds at which it is fastest. The error is the distance of the worst body from "
        "where it has to be at the end, of the same settings at the same step."
    )
    return Figure(
        f"bought-{number}", f"Error against throughput: {scene}", caption, finished(layers, HEIGHT), columns, cells, how
    )
