"""The charts of noise against its law: Allan deviation, range errors, and depth errors over depth."""

from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

from plumbline.harness.findings.sensor_readings.findings import SensorFinding
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.grammar import Row, channel, chart, hovering
from plumbline.reports.charts.ideal_signals import named
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import labels
from plumbline.reports.words.text import amount, slug, unit_text, visible

LAW = "#8a93a0"
"""Of what the law says; no engine has this colour."""


def noise_charts(store: Store, findings: Iterable[SensorFinding]) -> list[Figure]:
    """A chart for each noisy channel of each scene."""
    noisy = (finding for finding in findings if finding.curve is not None)
    groups = grouped(noisy, attrgetter("case", "where", "sensor", "channel"))
    drawn = {"imu": _allan, "lidar": _histogram, "depth_camera": _depth}
    return [drawn[group[0].type](store, group) for group in groups.values()]


def _points(store: Store, group: Sequence[SensorFinding], *names: str) -> tuple[list[Row], list[Row]]:
    """Rows of all engines, and those of the first alone, which say the law. Args: names: of at, found, law, low and high."""
    by_engine = []
    for finding in group:
        if (curve := finding.curve) is not None:
            values = zip(curve.at, curve.found, curve.law, curve.low, curve.high, strict=True)
            count = {"count": curve.count, "beyond": curve.beyond} if curve.count else {}
            said = _said(store, finding) | count
            by_engine.append([said | dict(zip(names, map(float, value), strict=True)) for value in values])
    return [row for rows in by_engine for row in rows], [{name: row[name] for name in names} for row in by_engine[0]]


def _said(store: Store, finding: SensorFinding) -> Row:
    return {
        "engine": labels(store)[finding.engine],
        "track": visible(finding.track)[:30],
        "series": f"{finding.engine} {finding.track}",
        "trial": finding.trial,
    }


def _name(kind: str, finding: SensorFinding) -> str:
    return slug(f"{kind}-{finding.case}-{finding.where}-{finding.sensor}-{finding.channel}".replace(" ", "-"))


def _layers(
    store: Store,
    rows: Sequence[Row],
    law: Sequence[Row],
    x: Any,
    y: Callable[[str], Any],
    tooltips: Sequence[Any],
    joined: bool = False,
) -> list[Any]:
    """The law as a line, in its band where it has one, then every engine's findings; y: the upright axis on a field."""
    style = Marks(store, rows)
    layers = []
    if "low" in law[0]:
        layers.append(chart(law).marked("area", opacity=0.28, color=LAW).encode(x=x, y=y("low"), y2="high:Q"))
    layers.append(chart(law).marked("line", strokeWidth=2.2, color=LAW).encode(x=x, y=y("law")))
    if joined:
        line = chart(rows).marked("line", strokeWidth=1.2)
        layers.append(line.encode(x=x, y=y("value"), detail="series:N", color=style.colour(), strokeDash=style.dash()))
    channels = style.channels() | {"tooltip": list(tooltips)}
    layers.append(chart(rows).marked("point", **POINT | {"size": 42}).encode(x=x, y=y("value"), **channels))
    return layers


def _tooltips(*numbers: tuple[str, str]) -> list[Any]:
    words = hovering("engine:N", "track:N")
    return [*words, *(channel(f"{f}:Q", title=t, format=".4~g") for f, t in numbers), channel("trial:N")]


def _allan(store: Store, group: Sequence[SensorFinding]) -> Figure:
    first, known = group[0], group[0].noise.law
    rows, law = _points(store, group, "tau", "value", "law", "low", "high")
    x = logarithmic("tau", "averaging time [s]", decades(row["tau"] for row in rows))
    span = decades(row[key] for row in rows for key in ("value", "low", "high"))

    def y(field: str) -> Any:
        return logarithmic(field, f"Allan deviation [{unit_text(first.unit)}]", span)

    tooltips = _tooltips(("tau", "averaging time [s]"), ("value", "found"), ("law", "by law"))
    caption = "Overlapping Allan deviation of the noise against its law, in grey."
    how = (
        f"Root mean square over the axes. Grey is the law ({unit_text(known)}), exactly, with "
        "the band in which 19 of 20 findings lie. The same stream of noise is laid over every engine's signal, so marks lie on "
        "one another where an engine adds nothing of its own."
    )
    spec = finished(_layers(store, rows, law, x, y, tooltips, joined=True), height=280)
    columns = ("engine", "setting", "averaging time [s]", f"found [{unit_text(first.unit)}]", "by law", "trial")
    cells = [[r["engine"], r["track"], amount(r["tau"]), amount(r["value"]), amount(r["law"]), r["trial"]] for r in rows]
    return Figure(_name("allan", first), f"{named(store, first)}, Allan deviation", caption, spec, columns, cells, how)


def _histogram(store: Store, group: Sequence[SensorFinding]) -> Figure:
    first = group[0]
    rows, law = _points(store, group, "at", "value", "law", "low", "high")
    x = channel("at:Q", title="range error over its standard deviation by law", scale={"domain": [-4, 4], "nice": False})

    def y(field: str) -> Any:
        return channel(f"{field}:Q", title="density")

    tooltips = _tooltips(("at", "error, in sigmas"), ("value", "found"), ("law", "normal law"), ("count", "returns"))
    caption = "Errors of all returned ranges, each over the standard deviation that the law gives it."
    how = f"The law is {first.noise.law}. Grey: the normal law, with the band in which 19 of 20 bins lie."
    spec = finished(_layers(store, rows, law, x, y, tooltips), height=260)
    columns = ("engine", "setting", "error, in sigmas", "density", "normal law", "returns", "beyond 4 sigmas", "trial")
    cells = [
        [r["engine"], r["track"], amount(r["at"]), amount(r["value"]), amount(r["law"]), r["count"], r["beyond"], r["trial"]]
        for r in rows
    ]
    return Figure(_name("ranges", first), f"{named(store, first)}, errors", caption, spec, columns, cells, how)


def _depth(store: Store, group: Sequence[SensorFinding]) -> Figure:
    first = group[0]
    rows, law = _points(store, group, "depth", "value", "law", "least", "most")
    law = [{name: point[name] for name in ("depth", "law")} for point in law]
    x = channel("depth:Q", title="depth [m]", scale={"zero": False, "padding": 14})
    span = decades(row["value"] for row in rows)

    def y(field: str) -> Any:
        return logarithmic(field, "spread of the depth error [m]", span)

    tooltips = _tooltips(
        ("depth", "depth [m]"), ("value", "found [m]"), ("law", "by law [m]"), ("least", "95 % from"), ("most", "to")
    )
    caption = "Standard deviation of the error of valid pixels against its law, in grey."
    how = f"In stretches of depth of equally many pixels; the law is {first.noise.law}."
    spec = finished(_layers(store, rows, law, x, y, tooltips), height=280)
    columns = ("engine", "setting", "depth [m]", "spread [m]", "95 % from", "to", "by law", "trial")
    keys = ("depth", "value", "least", "most", "law")
    cells = [[r["engine"], r["track"], *(amount(r[key]) for key in keys), r["trial"]] for r in rows]
    return Figure(_name("depths", first), f"{named(store, first)}, spread over depth", caption, spec, columns, cells, how)
