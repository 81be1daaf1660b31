"""The figures of a run for other trackers of benchmarks: airspeed velocity's results, and Bencher's metric format.

Sources: asv, 'Developer docs', file format of results, version 2 (columns of each benchmark under 'result_columns'); Bencher,
'Bencher Metric Format' (benchmark, measure, value with lower_value and upper_value).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from plumbline.harness.findings.parameter_words import where_of
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store

_COLUMNS = ["result", "params", "version", "started_at", "duration", "stats_ci_99_a", "stats_ci_99_b", "stats_q_25",
            "stats_q_75", "number", "repeat", "samples", "profile"]  # fmt: skip
"""In the order in which asv writes them; trailing ones may be left out of a row."""


@dataclass(frozen=True, slots=True)
class _Figure:
    """One number of one trial. Terms: values by name, ordered: what asv calls parameters."""

    benchmark: str
    settings: tuple[str, str, str]
    value: float
    low: float
    high: float


def _name(row: Any, store: Store) -> str:
    """The case; a trial that departs from the case's parameters, or counts something else than steps, is another benchmark."""
    where = where_of(store.catalogue, row.case, row.parameters)
    unit = row.unit if isinstance(row.unit, str) and row.unit != "step" else ""
    return str(row.case) + (f"({where})" if where else "") + (f".{unit}" if unit else "")


def _beside(row: Any) -> bool:
    """Was something else clocked than the work itself, once?"""
    return getattr(row, "workers", 1) != 1 or getattr(row, "clocks", "work") != "work"


def _prices(store: Store) -> Iterator[_Figure]:
    for row in store.asked.itertuples():
        if row.cpu_per_unit == row.cpu_per_unit and not _beside(row):
            yield _Figure(
                _name(row, store), (row.engine, row.track, f"{row.dt:.6g}"), float(row.cpu_per_unit),
                float(row.cpu_per_unit_low), float(row.cpu_per_unit_high),
            )  # fmt: skip


def _errors(store: Store) -> Iterator[_Figure]:
    cases = store.catalogue.get("cases", {})
    values = {(str(m.trial), str(m.metric)): m for m in store.measurements.itertuples()}
    for row in store.asked.itertuples():
        headline = values.get((str(row.trial), str(cases.get(row.case, {}).get("headline"))))
        if headline is not None and math.isfinite(headline.value):
            off = float(getattr(headline, "truth_error", 0.0) or 0.0)
            value = float(headline.value)
            yield _Figure(_name(row, store), (row.engine, row.track, f"{row.dt:.6g}"), value, value - off, value + off)


def bencher(store: Store) -> dict[str, dict[str, dict[str, float]]]:
    """By benchmark 'case/engine/track/dt': the measures 'latency' [ns of CPU time a unit] and 'error' [the case's own unit]."""
    made: dict[str, dict[str, dict[str, float]]] = {}
    for measure, scale, figures in (("latency", 1e9, _prices(store)), ("error", 1.0, _errors(store))):
        for figure in figures:
            name = "/".join((figure.benchmark, *figure.settings))
            value = {"value": scale * figure.value, "lower_value": scale * figure.low, "upper_value": scale * figure.high}
            made.setdefault(name, {})[measure] = value
    return made


def asv(store: Store) -> dict[str, Any]:
    """A results file of version 2: for each case a time_ benchmark [s] and a track_ one (the error), over engine, track, dt."""
    machine = store.machine
    started = _milliseconds(machine.get("started"))
    results: dict[str, list[Any]] = {}
    for prefix, figures in (("time", list(_prices(store))), ("track", list(_errors(store)))):
        for benchmark in dict.fromkeys(figure.benchmark for figure in figures):
            mine = {figure.settings: figure for figure in figures if figure.benchmark == benchmark}
            axes = [list(dict.fromkeys(settings[k] for settings in mine)) for k in range(3)]
            grid = [mine.get((engine, track, dt)) for engine in axes[0] for track in axes[1] for dt in axes[2]]
            results[f"plumbline.{prefix}_{benchmark}"] = [
                [None if figure is None else figure.value for figure in grid],
                [[f"'{value}'" for value in axis] for axis in axes],
                "1",
                started,
                0.0,
                [None if figure is None else figure.low for figure in grid],
                [None if figure is None else figure.high for figure in grid],
            ]
    properties = {"machine": machine_digest(machine) or "unknown", "cpu": str(machine.get("processor", "")),
                  "num_cpu": str(machine.get("cores", "")), "os": str(machine.get("system", "")),
                  "ram": str(machine.get("memory_mb", "")), "arch": ""}  # fmt: skip
    python = str(machine.get("python", ""))
    commit = digest(sorted(store.trials["trial"]))  # names of trials cover versions and sources, as a commit would
    return {
        "version": 2, "commit_hash": commit, "date": started, "env_name": f"existing-py{python}", "python": python,
        "requirements": {str(k): str(v) for k, v in (machine.get("packages") or {}).items()}, "env_vars": {},
        "params": properties, "result_columns": _COLUMNS, "results": results, "durations": {},
    }  # fmt: skip


def _milliseconds(text: Any) -> int:
    """Since 1970, as asv counts them; 0 for no date."""
    try:
        return int(datetime.fromisoformat(str(text)).timestamp() * 1000)
    except ValueError:
        return 0
