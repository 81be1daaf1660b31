"""The charts of ideal signals and of rays: how far each signal is off, against its bound, and how many rays a second buys."""

import re
from collections.abc import Mapping, Sequence

from plumbline.harness.findings.sensor_readings.findings import SensorFinding
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.grammar import Row, channel, chart, fixed, hovering
from plumbline.reports.charts.marks import POINT, Marks, decades, finished, logarithmic
from plumbline.reports.words.catalogue import labels, titled
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import amount, slug, unit_text, visible

UNITS: Mapping[str, str] = {
    "m": "Ranges and depths",
    "m/s2": "Accelerations",
    "rad/s": "Turning rates",
    "1": "Intensity of light",
}
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
    channels = style.channels() | {"tooltip": tooltips}
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
    columns = ("signal", "engine", "setting", f"error{beside_number}", "bound", "check", "trial")
    cells = [
        [r["signal"], r["engine"], r["track"], amount(r["error"]), amount(r["bound"]), r["verdict"], r["trial"]] for r in rows
    ]
    name = f"ideal-{slug(unit.replace('/', '-per-'))}" if unit != "1" else "ideal-light"
    return Figure(name, title, caption, finished(layers, height=40 + 44 * len(signals)), columns, cells, how)


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
    layer = chart(rows).marked("point", **POINT).encode(x=x, y=y, **(style.channels() | {"tooltip": tooltips}))
    caption = "Beams of range finders and pixels of cameras, on one thread. Farther right is cheaper."
    how = (
        "Bare rays are cast and no more; what is read has been stepped for, cast, made into ranges, depths and intensities, "
        "and had its noise laid over."
    )
    columns = ("scene", "rays", "engine", "setting", "a CPU second", "trial")
    cells = [[r["scene"], r["kind"], r["engine"], r["track"], amount(r["rate"]), r["trial"]] for r in rows]
    return Figure(
        "sensor-rays",
        "What a second of CPU time sees",
        caption,
        finished([layer], height=40 + 34 * len(labelled)),
        columns,
        cells,
        how,
    )
