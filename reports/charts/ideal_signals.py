"""The charts of ideal signals and of rays: how far each signal is off, against its bound, and how many rays a second buys.

The charts of noise against its law: Allan deviation, range errors, and depth errors over depth.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

from plumbline.harness.findings.sensor_readings.findings import SensorFinding
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, channel, chart, fixed, hovering
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import labels, titled
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import slug, unit_text, visible

UNITS = WORDS["signals"]
"""Titles of the charts by unit, in the order of the page."""


LINES: Row = {"labelExpr": "split(datum.label, ': ')", "labelLimit": 230, "grid": True, "ticks": False}
"""Of an axis of names: what stands after a colon goes to a line of its own."""


def named(store: Store, finding: SensorFinding) -> str:
    """A channel in words: its case, its sensor and what it reads."""
    return visible(f"{titled(store, finding.case, finding.where)}: {reading(finding)}")[:90]


def reading(finding: SensorFinding) -> str:
    """What a sensor reads, in words: 'lidar range', and of a sensor named for it the one word."""
    of = finding.channel if finding.sensor == finding.channel else f"{finding.sensor} {finding.channel}"
    return re.sub(r"\bimu\b", "IMU", of.replace("_", " "))


def _row(store: Store, finding: SensorFinding) -> Row:
    return {
        "engine": labels(store)[finding.engine],
        "track": visible(finding.track)[:30],
        "signal": named(store, finding),
        "error": finding.error,
        "bound": finding.at_most,
        "metric": visible(metric_title(finding.metric)) if finding.metric else f"largest error of {finding.channel}",
        "unit": finding.unit,
        "median": finding.error_median,
        "verdict": "" if finding.passed is None else "holds" if finding.passed else "fails",
        "symbol": outcome(finding.status).symbol,
        "reason": visible(finding.reason)[:200],
        "trial": finding.trial,
    }


def error_charts(store: Store, findings: Sequence[SensorFinding]) -> list[Figure]:
    """A chart for each unit; channels without a truth are left out."""
    charts = []
    for unit, title in UNITS.items():
        rows = [_row(store, finding) for finding in findings if finding.unit == unit and finding.error is not None]
        if any(row["error"] > 0 for row in rows):
            charts.append(_errors(store, rows, unit, title))
    return charts


def _errors(store: Store, rows: Sequence[Row], unit: str, title: str) -> Figure:
    style = Marks(store, rows)
    signals = list(dict.fromkeys(row["signal"] for row in rows))
    finite = [row for row in rows if row["error"] == row["error"] and 0 < row["error"] < float("inf")]
    bounded = dict.fromkeys((row["signal"], row["bound"]) for row in rows if row["bound"])
    bounds = [{"signal": signal, "bound": bound} for signal, bound in bounded]
    spread = [row["error"] for row in finite] + [row["bound"] for row in bounds]
    beside_number = "" if unit == "1" else f" [{unit_text(unit)}]"
    across = f"error of the ideal signal{beside_number}"
    x = logarithmic("error", across, decades(spread))
    y = channel("signal:N", title=None, scale={"domain": signals}, axis=LINES)
    beside = channel("engine:N", scale={"domain": style.engines})
    tooltips = hovering(
        "signal:N",
        "engine:N",
        "track:N",
        "metric:N",
        ("error:Q", f"error{beside_number}", ".4~g"),
        ("median:Q", "median", ".4~g"),
        ("bound:Q", "", ".4~g"),
        "verdict:N",
        "reason:N",
        "trial:N",
    )
    channels = style.channels(tooltips)
    layers = []
    if bounds:
        grey: Row = {"color": "#8a93a0", "thickness": 2.5, "orient": "vertical", "size": 34}
        layers.append(chart(bounds).marked("tick", **grey).encode(x=channel("bound:Q", title=across), y=y))
    layers.append(chart(finite).marked("point", **POINT).encode(x=x, y=y, yOffset=beside, **channels))
    for edge, at in (("exact", fixed(0)), ("lost", fixed("width"))):
        placed = [row for row in rows if (row["error"] == 0 if edge == "exact" else not row["error"] < float("inf"))]
        if placed:
            layers.append(chart(placed).marked("point", **POINT).encode(x=at, y=y, yOffset=beside, **channels))
    caption = "Left is more accurate; right of the grey stroke a check fails."
    how = (
        "How far each engine's signal without noise lies from the truth, by the statistic that the case judges; open for the "
        "vendor's defaults. The grey stroke is the bound, derived in the case. Exact "
        "answers stand on the left edge, what is no number on the right one."
    )
    columns = ("signal", "engine", "setting=track", f"error{beside_number}=error", "bound", "check=verdict", "trial")
    name = f"ideal-{slug(unit.replace('/', '-per-'))}" if unit != "1" else "ideal-light"
    return Figure(name, title, caption, finished(layers, height=40 + 44 * len(signals)), *tabled(rows, *columns), how)


def rays_chart(store: Store, findings: Sequence[SensorFinding]) -> Figure | None:
    """Rays a CPU second, bare and with all that makes a reading of them; None where nothing was clocked."""
    rows: list[Row] = []
    for finding in findings:
        same = {
            "engine": labels(store)[finding.engine],
            "track": finding.track,
            "scene": titled(store, finding.case, finding.where),
        }
        if finding.channel not in ("range", "depth", "colour"):
            continue
        for kind, rate, trial in (
            ("read, with noise", finding.rays_per_s, finding.trial_sensing),
            ("bare", finding.bare_rays_per_s, finding.trial_bare),
        ):
            if rate:
                row = same | {"kind": kind, "rate": rate, "trial": trial}
                if row not in rows:
                    rows.append(row)
    if not rows:
        return None
    style = Marks(store, rows)
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    kinds = [kind for kind in ("bare", "read, with noise") if any(row["kind"] == kind for row in rows)]
    labelled = [f"{scene}: {kind}" for scene in scenes for kind in kinds]
    rows = [row | {"label": f"{row['scene']}: {row['kind']}"} for row in rows]
    labelled = [label for label in labelled if any(row["label"] == label for row in rows)]
    x = logarithmic("rate", "rays a CPU second", decades(row["rate"] for row in rows))
    y = channel("label:N", title=None, scale={"domain": labelled}, axis=LINES)
    tooltips = hovering("scene:N", ("kind:N", "rays"), "engine:N", "track:N", ("rate:Q", "a CPU second", ".3~s"), "trial:N")
    layer = chart(rows).marked("point", **POINT).encode(x=x, y=y, **style.channels(tooltips))
    caption = "Beams of range finders and pixels of cameras, on one thread. Farther right is cheaper."
    how = (
        "Bare rays are cast and no more; what is read has been stepped for, cast, made into ranges, depths and intensities, "
        "and had its noise laid over."
    )
    spec = finished([layer], height=40 + 34 * len(labelled))
    table = tabled(rows, "scene", "rays=kind", "engine", "setting=track", "a CPU second=rate", "trial")
    return Figure("sensor-rays", "What a second of CPU time sees", caption, spec, *table, how)


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
            labelled = _said(store, finding) | count
            by_engine.append([labelled | dict(zip(names, map(float, value), strict=True)) for value in values])
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
    layers.append(chart(rows).marked("point", **POINT | {"size": 42}).encode(x=x, y=y("value"), **style.channels(tooltips)))
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
    column_found = f"found [{unit_text(first.unit)}]=value"
    table = tabled(rows, "engine", "setting=track", "averaging time [s]=tau", column_found, "by law=law", "trial")
    return Figure(_name("allan", first), f"{named(store, first)}, Allan deviation", caption, spec, *table, how)


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
    numbers = ("error, in sigmas=at", "density=value", "normal law=law", "returns=count", "beyond 4 sigmas=beyond")
    table = tabled(rows, "engine", "setting=track", *numbers, "trial")
    return Figure(_name("ranges", first), f"{named(store, first)}, errors", caption, spec, *table, how)


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
    numbers = ("depth [m]=depth", "spread [m]=value", "95 % from=least", "to=most", "by law=law")
    table = tabled(rows, "engine", "setting=track", *numbers, "trial")
    return Figure(_name("depths", first), f"{named(store, first)}, spread over depth", caption, spec, *table, how)
