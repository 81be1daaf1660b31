"""What a step, a ray or a world costs, engine beside engine: the rows of the scaling table, made from a run folder.

A price alone says little, so each stands beside what it buys: how deep bodies stand in one another, how much still moves, or,
where nothing touches, the case's own error. Ratios are taken within blocks of samples, which cancels what the machine did.

What was clocked beside the work (steps whose state is read, empty calls, several processes side by side) is compared with the
same engine's plain step and with nobody else's.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from plumbline.harness.findings.columns import Column, Row, Table, known, spread
from plumbline.harness.findings.cost_point import BlockSample, Clock, SampledBlock, ratio_in_blocks, samples_by_block
from plumbline.harness.findings.costs import PENETRATION, RESIDUAL, Cost, Exponent, Sweep, growth, no_worse, whole
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.parameter_words import called, differing, other_values, said, with_substeps
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import FEWEST
from plumbline.harness.store.store import Store

_REASON = 64
"""Characters of why a priced run failed; what an engine could not hold comes first, and the whole is in the CSV."""
CLOCKED = {
    "work": "step alone",
    "reading": "step and reading",
    "call": "empty call",
    "casting": "bare rays",
    "sensing": "sensing",
}
"""What runs under the clock, in the words that set the rows apart."""


COLUMNS = (
    "row", "case", "where", "engine", "track", "unit", "cpu_s", "cpu_low_s", "cpu_high_s", "to_fastest", "to_fastest_low",
    "to_fastest_high", "reference", "reference_low", "reference_high", "reference_setting", "penetration_m", "residual_m_s",
    "error", "error_metric", "best", "exponent", "exponent_low", "exponent_high", "unstable", "status", "reason", "dt",
    "substeps", "trial", "clocks", "workers", "units", "to_plain", "to_plain_low", "to_plain_high", "rate_per_s", "efficiency",
    "efficiency_low", "efficiency_high", "emulated",
)  # fmt: skip
"""Of the flat rows: 'cost' rows and 'exponent' rows share them; what a row has not is None, and so an exponent not known."""


def _number(value: Any) -> float | None:
    return float(value) if value is not None and pd.notna(value) and math.isfinite(value) else None


class Scaling:
    """The costs and exponents of a run folder, read once."""

    def __init__(self, store: Store) -> None:
        self._store = store
        engines = store.catalogue.get("engines", {})
        self._ours = {name for name, engine in engines.items() if engine.get("ours")}

    @cached_property
    def _samples(self) -> Mapping[str, Mapping[SampledBlock, BlockSample]]:
        return samples_by_block(self._store)

    @cached_property
    def _values(self) -> Mapping[str, Mapping[str, float]]:
        """Metric values by trial; of a metric that is checked twice the first."""
        by_trial: dict[str, dict[str, float]] = {}
        table = self._store.measurements
        for trial, metric, value in zip(table["trial"], table["metric"], table["value"], strict=True):
            by_trial.setdefault(trial, {}).setdefault(metric, value)
        return by_trial

    def _own(self, case: str) -> Mapping[str, Any]:
        """The parameters that a case has of itself."""
        own: Mapping[str, Any] = self._store.catalogue.get("cases", {}).get(case, {}).get("parameters", {})
        return own

    def _groups(self) -> Iterator[tuple[str, str, pd.DataFrame]]:
        """Trials that were clocked together: one case at one set of parameters and one time step."""
        for (case, _), trials in self._store.asked.groupby(["case", "experiment"], sort=False):
            given = _given(trials)
            swept = differing(given, self._own(case))
            where = [", ".join(said(str(case), name, parameters.get(name)) for name in swept) for parameters in given]
            keyed = trials.assign(
                where=where, given=given, size=[[_size(parameters.get(name)) for name in swept] for parameters in given]
            )
            for (beside, _), group in keyed.sort_values("size", kind="stable").groupby(["where", "dt"], sort=False):
                yield case, beside, group

    @cached_property
    def costs(self) -> tuple[Cost, ...]:
        """All rows, scene by scene; within a scene engine by engine, each from the cheapest setting to the dearest."""
        priced: list[Cost] = []
        for case, where, group in self._groups():
            rows = [self._cost(case, where, row) for row in group.to_dict("records")]
            if any(row.cpu is not None for row in rows):
                priced += rows if any(row.beside for row in rows) else self._compared(rows)
        return tuple(self._beside(priced))

    def _cost(self, case: str, where: str, row: Mapping[str, Any]) -> Cost:
        values, cpu = self._values.get(row["trial"], {}), _number(row.get("cpu_per_unit"))
        headline = self._store.catalogue.get("cases", {}).get(case, {}).get("headline", "")
        note = row.get("timing_note")  # a run folder of an older version has no such column
        trouble = [f"timing: {note}"] if isinstance(note, str) and note else []
        unstable, workers = row["unstable_timing"], int(row.get("workers", 1))
        return Cost(
            case=case,
            where=where,
            parameters=row["given"],
            engine=row["engine"],
            track=row["track"],
            unit=str(row["unit"]) if pd.notna(row.get("unit")) else "",
            cpu=None
            if cpu is None
            else Interval(cpu, _number(row.get("cpu_per_unit_low")), _number(row.get("cpu_per_unit_high"))),
            penetration=next((_number(values[name]) for name in PENETRATION if name in values), None),
            residual=next((_number(values[name]) for name in RESIDUAL if name in values), None),
            error=_number(values.get(headline)),
            error_metric=headline,
            unstable=None if pd.isna(unstable) else bool(unstable),
            status=row["status"],
            reason="; ".join([row["reason"], *trouble]) if row["status"] != "passed" else "; ".join(trouble),
            dt=float(row["dt"]),
            trial=row["trial"],
            experiment=row["experiment"],
            clocks=row.get("clocks", "work"),
            workers=workers,
            emulated=_number(row.get("emulated")),
            units=next((s.units for s in self._samples.get(row["trial"], {}).values()), workers) // workers,
        )

    def _ratio(self, row: Cost, base: Cost, clock: Clock = "cpu") -> Interval | None:
        return ratio_in_blocks(self._samples.get(row.trial, {}), self._samples.get(base.trial, {}), clock)

    def _rate(self, row: Cost) -> float | None:
        """Units in a second of wall time."""
        samples = self._samples.get(row.trial, {}).values()
        return float(np.median([s.count / s.wall for s in samples])) if samples else None

    def _beside(self, rows: Sequence[Cost]) -> Iterator[Cost]:
        """What stands beside the work, compared with the plain step of one process in the same blocks."""

        def side(row: Cost) -> tuple[object, ...]:
            kept = {name: value for name, value in row.parameters.items() if name not in ("clocked", "workers")}
            return row.case, row.experiment, row.engine, row.track, row.dt, json.dumps(kept, sort_keys=True)

        plain = {side(row): row for row in rows if row.beside and (row.clocks, row.workers) == ("work", 1)}
        for row in rows:
            changed: dict[str, Any] = {}
            base = plain.get(side(row)) if row.beside and row.cpu is not None else None
            if base is not None and row.clocks != "work":
                changed["to_plain"] = self._ratio(row, base)
            if base is not None and row.clocks == "work" and "workers" in row.parameters:
                # A unit's wall time, all processes counted, over that of one process: the inverse of the speed-up.
                slower = self._ratio(row, base, "wall")
                if slower is not None:
                    low, high = slower.ends
                    changed["efficiency"] = Interval(*(1 / (row.workers * each) for each in (slower.value, high, low)))
                changed["rate"] = self._rate(row)
            yield replace(row, **changed)

    def _compared(self, rows: Sequence[Cost]) -> list[Cost]:
        timed = sorted((row for row in rows if row.cpu is not None), key=lambda row: row.cpu.value if row.cpu else 0.0)
        sound = [row for row in timed if row.status == "passed"]
        best = {engine: next(row for row in sound if row.engine == engine) for engine in {row.engine for row in sound}}
        fastest = next((row for row in sound if row.engine not in self._ours), None)
        compared = []
        for row in [*timed, *(row for row in rows if row.cpu is None)]:
            rival = next((own for own in sound if own.engine in self._ours and no_worse(own, row)), None)
            compared.append(
                replace(
                    row,
                    to_fastest=self._ratio(row, fastest) if fastest is not None else None,
                    reference=self._ratio(rival, row) if rival is not None and row.cpu is not None else None,
                    reference_setting=rival.track if rival is not None else "",
                    best=best.get(row.engine) is row,
                )
            )
        order = list(dict.fromkeys(row.engine for row in rows))
        return sorted(compared, key=lambda row: order.index(row.engine))

    @cached_property
    def sweeps(self) -> tuple[Sweep, ...]:
        """The rows along each numeric parameter that was run at three values or more while the others were kept."""
        along: dict[tuple[str, str, str, str, float], list[Cost]] = {}
        for row in self.costs:
            for name, value in row.parameters.items() if not row.beside else ():
                if row.cpu is not None and isinstance(value, int | float) and not isinstance(value, bool) and name != "seed":
                    others = {n: v for n, v in row.parameters.items() if n != name}
                    key = (row.case, json.dumps(others, sort_keys=True), row.unit, name, row.dt)
                    along.setdefault(key, []).append(row)
        return tuple(
            whole(
                Sweep(
                    case=case,
                    where=", ".join(said(case, n, v) for n, v in other_values(json.loads(others), self._own(case)).items()),
                    unit=unit,
                    parameter=name,
                    rows=tuple(sorted(rows, key=lambda row: float(row.parameters[name]))),
                )
            )
            for (case, others, unit, name, _), rows in along.items()
            if len({row.parameters[name] for row in rows}) >= FEWEST
        )

    @cached_property
    def exponents(self) -> tuple[Exponent, ...]:
        """Fitted growth of each engine under each group of settings, along each sweep."""
        return tuple(
            fit
            for sweep in self.sweeps
            for side in dict.fromkeys((row.engine, row.track) for row in sweep.rows)
            if (fit := growth(sweep, [row for row in sweep.rows if (row.engine, row.track) == side])) is not None
        )

    def rows(self) -> list[dict[str, Any]]:
        """Flat rows with COLUMNS."""
        blank = dict.fromkeys(COLUMNS)
        flat = []
        for cost in self.costs:
            named = {"penetration_m": cost.penetration, "residual_m_s": cost.residual, "rate_per_s": cost.rate}
            prices = dict(zip(("cpu_s", "cpu_low_s", "cpu_high_s"), cost.cpu or (None,) * 3, strict=True))
            row = spread(cost) | named | prices | {"row": "cost"}
            flat.append({name: row.get(name) for name in COLUMNS})
        for exponent in self.exponents:
            sweep, fit = exponent.sweep, exponent.fit
            row = known(sweep, "case", "unit") | known(exponent, "engine", "track")
            along = f"{called(sweep.case, sweep.parameter)} from {fit.fine:g} to {fit.coarse:g}"
            row |= {"where": ", ".join(filter(None, (sweep.where, along))), "exponent": fit.order if exponent.telling else None}
            flat.append(blank | row | {"row": "exponent", "exponent_low": fit.low, "exponent_high": fit.high})
        return flat


def _costs(row: Row) -> str:
    if row["row"] == "exponent":
        stated = "not known" if row["exponent"] is None else f"{row['exponent']:.2f}"
        return f"exponent {stated} ({row['exponent_low']:.2f} to {row['exponent_high']:.2f})"
    if row["cpu_s"] is None:
        costs = "not clocked" if _answered(row) else ""
    else:
        costs = f"{_micro(row['cpu_s'])} us ({_micro(row['cpu_low_s'])}..{_micro(row['cpu_high_s'])})"
        if row["to_plain"] is not None:
            costs += f", {row['to_plain']:.3g} x the step alone"
        if row["efficiency"] is not None:
            costs += f", {row['rate_per_s']:,.0f} a second, efficiency {row['efficiency']:.2f}"
        if own := share_in_words(row["emulated"]):
            costs += f", {own}"
    return costs


def _answered(row: Row) -> bool:
    return row["status"] in ("passed", "failed")


def _status(row: Row) -> str:
    if row["row"] == "exponent":
        return ""
    if row["status"] == "failed" and row["cpu_s"] is not None:
        return f"failed: {row['reason'][:_REASON]}"
    return str(row["status"]) if _answered(row) and row["cpu_s"] is not None else f"{row['status']}: {row['reason']}"


def _micro(value: float) -> str:
    """In millionths, three digits of it, without a power of ten while it is readable."""
    return f"{value * 1e6:,.0f}" if value >= 1e-4 else f"{value * 1e6:.3g}"


def _given(trials: pd.DataFrame) -> list[dict[str, Any]]:
    """The parameters of trials; two more say what was clocked and in how many processes, where that is not the plain step."""
    given: list[dict[str, Any]] = [json.loads(text) for text in trials["parameters"]]
    for name, column, plain in (("clocked", "clocks", "work"), ("workers", "workers", 1)):
        if column in trials and (trials[column] != plain).any():
            given = [
                parameters | {name: CLOCKED.get(value, value)} for parameters, value in zip(given, trials[column], strict=True)
            ]
    return given


def _size(value: Any) -> tuple[int, float, str]:
    """Numbers by size, before words by alphabet."""
    return (0, float(value), "") if isinstance(value, int | float) else (1, 0.0, str(value))


TABLE = Table(
    columns=COLUMNS,
    objects=lambda store: with_substeps(store, Scaling(store).rows()),
    row=dict,
    shown=(
        Column("scene", lambda row: f"{row['case']} {row['where'] or ''}".strip()),
        Column("engine", "engine"),
        Column("setting", "track"),
        Column("a", "unit"),
        Column("costs", _costs),
        Column("x fastest", "to_fastest", ".3g"),
        Column(
            "reference x",
            lambda row: "" if row["reference"] is None else f"{row['reference']:.3g} ({row['reference_setting']})",
        ),
        Column("penetration", lambda row: "" if row["penetration_m"] is None else f"{_micro(row['penetration_m'])} um"),
        Column("moves", lambda row: "" if row["residual_m_s"] is None else f"{_micro(row['residual_m_s'])} um/s"),
        # * the engine's fastest whose checks hold, ~ an unstable timing
        Column("marks", lambda row: ("*" if row["best"] else "") + ("~" if row["unstable"] else "")),
        Column("status", _status),
    ),
)
