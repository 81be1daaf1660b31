"""What each sensor says on each engine: how far off its ideal signal is, whether its noise keeps its law, how late it is, and
what its rays cost.

One row a channel of a sensor on an engine and track; see `harness.findings.sensor_readings.findings.Finding` and, for
the columns law to walk, `harness.findings.sensor_readings.noise.Noise`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.columns import Column, Row, Table, names, scene, side, spread
from plumbline.harness.findings.parameter_words import columns_with_substeps, with_substeps
from plumbline.harness.findings.sensor_readings.findings import SKETCHES, SensorFinding, findings
from plumbline.harness.findings.sensor_readings.noise import Noise
from plumbline.harness.store.store import Store

OF_NOISE = tuple(name for name in names(Noise) if name not in ("count", "why"))


def _columns() -> tuple[str, ...]:
    """The fields of a finding, with those of its noise in its place."""
    own = (name for name in names(SensorFinding) if name not in SKETCHES)
    return columns_with_substeps([column for name in own for column in (OF_NOISE if name == "noise" else (name,))])


COLUMNS = _columns()


def _rows(store: Store) -> list[dict[str, Any]]:
    columns = [name for name in COLUMNS if name != "substeps"]
    whole = (spread(finding.noise) | spread(finding) for finding in findings(store))
    return with_substeps(store, ({name: row[name] for name in columns} for row in whole))


def _bound(row: Row) -> str:
    verdict = "" if row["passed"] is None else " holds" if row["passed"] else " fails"
    return _amount(row["at_most"], "") + verdict


def _sigma(row: Row) -> str:
    return _amount(row["sigma"], row["unit"]) + ("" if row["sigma_law"] is None else f" ({row['sigma_law']:.4g})")


def _lost(row: Row) -> str:
    return _share(row["lost"], "") + ("" if row["lost_law"] is None else f" ({100 * row['lost_law']:.3g} %)")


def _error(row: Row) -> str:
    """The error that is judged; what kind of mean it is, where it is no largest one."""
    if row["error"] is None:
        return _share(row["disagree"], " disagree")
    kind = next((word for word in ("median", "rms") if row["metric"].endswith(word)), "")
    return f"{_amount(row['error'], row['unit'])} {kind}".strip()


def _amount(value: float | None, unit: str) -> str:
    return "" if value is None else f"{value:.3g}{'' if unit in ('', '1') else ' ' + unit}"


def _share(value: float | None, word: str) -> str:
    return "" if value is None else f"{100 * value:.3g} %{word}"


def _rate(row: Row) -> str:
    parts = [
        f"{row[name]:.2g}{word}" for name, word in (("rays_per_s", ""), ("bare_rays_per_s", " bare")) if row[name] is not None
    ]
    return ", ".join(parts)


def sentences(rows: Sequence[Row], titles: Mapping[str, str] | None = None) -> list[str]:
    """Engine by engine, how many ideal signals stay within their bounds; then what noise costs beside bare rays.

    Args: titles: of engines and cases, by name; without them names stand."""
    lines, known = [], titles or {}
    for engine in dict.fromkeys(row["engine"] for row in rows):
        mine, called = [row for row in rows if row["engine"] == engine], known.get(engine, engine)
        judged = [row for row in mine if row["passed"] is not None]
        silent = sum(not row["channel"] for row in mine)
        if judged:
            kept = sum(row["passed"] for row in judged)
            text = f"{called}: {kept} of {len(judged)} ideal signals stay within their bounds"
            lines.append(text + (f"; {silent} without readings." if silent else "."))
        elif silent:
            lines.append(f"{called}: no readings in {silent} {'run' if silent == 1 else 'runs'}.")
    for row in rows:
        if row["times_bare"] is not None and row["channel"] == "range":
            name = f"{known.get(row['case'], row['case'])} {row['where']}".strip()
            engine = known.get(row["engine"], row["engine"])
            lines.append(f"{name}: on {engine}, {row['track']}, a ray that is read costs {row['times_bare']:.2g} bare ones.")
    return lines


TABLE = Table(
    columns=COLUMNS,
    objects=_rows,
    row=dict,
    shown=(
        Column("case", scene),
        Column("engine", side),
        Column("sensor", lambda row: f"{row['sensor']}/{row['channel']}" if row["channel"] else ""),
        Column("error", _error),
        Column("bound", _bound),
        Column("sigma (law)", _sigma),
        Column("lost (law)", _lost),
        Column("lag", lambda row: "" if row["lag"] is None else f"{1e3 * row['lag']:.4g} ms"),
        Column("rays a second", _rate),
        Column("outcome", lambda row: row["status"] + (f": {row['reason'][:60]}" if row["reason"] else "")),
    ),
    sentences=sentences,
)
