"""The charts of scenes of one's own: what a smaller step still moves, and who parts from the limit that is agreed."""

from collections.abc import Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from plumbline.harness.findings.agreement.found import ways
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled, thin
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import labels, titles
from plumbline.reports.words.text import slug, visible

LEAST = 1e-12
"""Shares of the size below this are not drawn: rounding, of which there may be no logarithm."""
TIME = "time [s]"


def _rows(store: Store, engine: str, track: str, time: Any, share: Any) -> list[Row]:
    """A series over time; the start, where all is equal, is left out."""
    name = labels(store)[engine]
    return [
        {
            "engine": name,
            "track": visible(track)[:30],
            "series": f"{engine} {track}",
            "time": float(t),
            "share": max(float(s), LEAST),
        }
        for t, s in zip(time, share, strict=True)
        if t > 0 and np.isfinite(s) and s > LEAST
    ]


def horizon_chart(store: Store, agreement: Agreement) -> Figure | None:
    """What the last halving of the step moves, over time, with the tolerance that ends the horizon."""
    drawn = [
        row
        for side in agreement.sides
        if side.limit.time is not None
        for row in _rows(store, side.engine, side.track, side.limit.time, side.limit.moved)
    ]
    caption = "How far the last halving of its time step has moved an engine's answer up to each instant."
    how = (
        "Shares are of the size of what moves. The grey line is the tolerance, a hundredth: where a curve crosses it, that "
        "engine's horizon ends. A straight rise on this axis is chaos."
    )
    return _over_time(
        store, drawn, f"case-{slug(agreement.case)}-horizon", "Horizon: what a smaller step still moves", (caption, how), 0.01
    )


def parting_chart(store: Store, agreement: Agreement) -> Figure | None:
    """How far each engine's limit lies from the one that is agreed, over time."""
    base, series = ways(agreement)
    drawn = [row for (engine, track), (time, share) in series.items() for row in _rows(store, engine, track, time, share)]
    engine, _, track = base.partition(", ")
    of_one = f"the limit of {titles(store).get(engine, engine)}, {track}, since none is agreed"
    against = "the agreed limit" if agreement.agreed else of_one
    caption = f"Distance of each engine's own limit, at a step of zero, from {against}."
    how = (
        "The largest up to each instant, as a share of the size of what moves. "
        "The grey line is how far that limit itself may be off: "
        "who stays about it agrees. A curve "
        "ends where its limit is no longer known; one that is the limit itself has none."
    )
    return _over_time(
        store, drawn, f"case-{slug(agreement.case)}-parting", "Who parts, and when", (caption, how), agreement.bar
    )


def _over_time(
    store: Store, drawn: Sequence[Row], name: str, title: str, words: tuple[str, str], line: float | None
) -> Figure | None:
    if not drawn:
        return None
    style = Marks(store, drawn)
    series = grouped(drawn, itemgetter("series"))
    placed = [row for curve in series.values() for row in thin(curve, "time", "share", 400)]
    x = channel("time:Q", title=TIME, axis={"grid": True, "tickCount": 6})
    y = logarithmic("share", "share of the size", decades([*(row["share"] for row in placed), line]))
    tooltips = hovering("engine:N", "track:N", ("time:Q", "", ".3f"), ("share:Q", "", ".3~e"))
    layers: list[Any] = []
    if line is not None and line > 0:
        ends = [min(row["time"] for row in placed), max(row["time"] for row in placed)]
        rule = chart([{"time": end, "share": max(line, LEAST)} for end in ends])
        layers.append(rule.marked("line", color="#8a93a0", strokeWidth=1.5).encode(x=x, y=y))
    layers.append(
        chart(placed)
        .marked("line", strokeWidth=1.6)
        .encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash(), tooltip=tooltips)
    )
    marked = [curve[k] for curve in series.values() for k in sorted({len(curve) // 3, 2 * len(curve) // 3, len(curve) - 1})]
    look = POINT | {"size": 55}
    layers.append(chart(marked).marked("point", **look).encode(x=x, y=y, **style.channels(tooltips)))
    caption, how = words
    table = tabled(marked, "engine", "track", f"{TIME}=time", "share of the size=share")
    return Figure(name, title, caption, finished(layers, height=320), *table, how)
