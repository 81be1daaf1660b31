"""What each sensor says on each engine: how far off its ideal signal is, whether its noise keeps its law, how late it is, and
what its rays cost.

One row a channel of a sensor on an engine and track; see `harness.findings.sensor_readings.findings.Finding` and, for
the columns law to walk, `harness.findings.sensor_readings.channel.Noise`.
"""

from collections.abc import Mapping, Sequence

from plumbline.harness.findings.columns import Column, Table, at, names, scene, side
from plumbline.harness.findings.sensor_readings.channel import Noise
from plumbline.harness.findings.sensor_readings.findings import SKETCHES, SensorFinding, findings


def _bound(row: SensorFinding) -> str:
    verdict = "" if row.passed is None else " holds" if row.passed else " fails"
    return _amount(row.at_most, "") + verdict


def _sigma(row: SensorFinding) -> str:
    return _amount(at(row, "noise.sigma.value"), row.unit) + (
        "" if row.noise.sigma_law is None else f" ({row.noise.sigma_law:.4g})"
    )


def _lost(row: SensorFinding) -> str:
    law = row.noise.lost_law
    return _share(at(row, "noise.lost.value"), "") + ("" if law is None else f" ({100 * law:.3g} %)")


def _error(row: SensorFinding) -> str:
    """The error that is judged; what kind of mean it is, where it is no largest one."""
    if row.error is None:
        return _share(row.disagree, " disagree")
    kind = next((word for word in ("median", "rms") if row.metric.endswith(word)), "")
    return f"{_amount(row.error, row.unit)} {kind}".strip()


def _amount(value: float | None, unit: str) -> str:
    return "" if value is None else f"{value:.3g}{'' if unit in ('', '1') else ' ' + unit}"


def _share(value: float | None, word: str) -> str:
    return "" if value is None else f"{100 * value:.3g} %{word}"


def _rate(row: SensorFinding) -> str:
    rates = ((row.rays_per_s, ""), (row.bare_rays_per_s, " bare"))
    return ", ".join(f"{rate:.2g}{word}" for rate, word in rates if rate is not None)


def sentences(rows: Sequence[SensorFinding], titles: Mapping[str, str] | None = None) -> list[str]:
    """Engine by engine, how many ideal signals stay within their bounds; then what noise costs beside bare rays.

    Args: titles: of engines and cases, by name; without them names stand."""
    lines, known = [], titles or {}
    for engine in dict.fromkeys(row.engine for row in rows):
        mine, called = [row for row in rows if row.engine == engine], known.get(engine, engine)
        judged = [row for row in mine if row.passed is not None]
        silent = sum(not row.channel for row in mine)
        if judged:
            kept = sum(bool(row.passed) for row in judged)
            text = f"{called}: {kept} of {len(judged)} ideal signals stay within their bounds"
            lines.append(text + (f"; {silent} without readings." if silent else "."))
        elif silent:
            lines.append(f"{called}: no readings in {silent} {'run' if silent == 1 else 'runs'}.")
    for row in rows:
        if row.times_bare is not None and row.channel == "range":
            name = f"{known.get(row.case, row.case)} {row.where}".strip()
            engine = known.get(row.engine, row.engine)
            lines.append(f"{name}: on {engine}, {row.track}, a ray that is read costs {row.times_bare:.2g} bare ones.")
    return lines


TABLE = Table(
    holds=names(SensorFinding, *SKETCHES).replace(" noise ", f" {names(Noise, 'count', 'why', path='noise')} "),
    objects=findings,
    shown=(
        Column("case", scene),
        Column("engine", side),
        Column("sensor", lambda row: f"{row.sensor}/{row.channel}" if row.channel else ""),
        Column("error", _error),
        Column("bound", _bound),
        Column("sigma (law)", _sigma),
        Column("lost (law)", _lost),
        Column("lag", lambda row: "" if row.lag is None else f"{1e3 * row.lag:.4g} ms"),
        Column("rays a second", _rate),
        Column("outcome", lambda row: row.status + (f": {row.reason[:60]}" if row.reason else "")),
    ),
    sentences=sentences,
)
