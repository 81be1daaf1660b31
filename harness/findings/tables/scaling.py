"""What a step, a ray or a world costs, engine beside engine (over 400 lines: prices, sweeps and exponents with their table).

A price alone says little, so each stands beside what it buys: how deep bodies stand in one another, how much still moves, or,
where nothing touches, the case's own error. Ratios are taken within blocks of samples, which cancels what the machine did.

What was clocked beside the work (steps whose state is read, empty calls, several processes side by side) is compared with the
same engine's plain step and with nobody else's.

What a step, a ray or a world costs: a price with what it buys, prices along a parameter, and how they grow.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from plumbline.harness.findings.columns import Column, Table, at, plain, scene
from plumbline.harness.findings.cost_point import BlockSample, Clock, SampledBlock, ratio_in_blocks, samples_by_block
from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import called, differing, other_values, said, substeps_taken
from plumbline.harness.findings.spoken import SPOKEN
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import FEWEST, Order, fit_order
from plumbline.harness.store.rows import finite
from plumbline.harness.store.store import Store

TELLING = 1.0
"""The widest 95 % interval of an exponent that is stated.

Laws of growth that people tell apart are whole powers: constant, linear, quadratic. An interval narrower than the distance
between two of them holds one at most; a wider one always holds one and may hold two, and does not say whether twice the size
costs twice or four times as much. Three sizes leave a single degree of freedom, where Student's t is 12.7: over two decades a
price at the middle one that is off by a sixth makes the interval that wide."""

PENETRATION = ("overlap", "penetration")
"""Metrics [m] that say how deep bodies stand in one another, the more trusted one first."""
RESIDUAL = ("rms_speed",)
SMALLEST = {"penetration": 1e-6, "residual": 1e-5, "error": 1e-6}
"""Below a micrometre, 10 micrometres a second, or a millionth of an error's unit, two answers count as equally good."""
WHOLE = {"ray": ("cast", "rays"), "world-step": ("batch-step", "worlds")}
"""Where the number of what is counted is swept, the price of all together, and the name of that number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """A row: one engine under one group of settings in one scene.

    Terms:
        where: the parameters that tell the scene from the case's others. unit: what is counted. cpu [s]: of one unit.
        to_fastest: over the fastest setting whose checks hold of any engine that people can deploy. reference: what the
        reference engine takes over this row, at its fastest setting that penetrates no more and moves no more (or, without
        contact, errs no more) than this row; reference_setting names it.
        penetration [m]; residual [m/s]: root mean square speed of the worst body when all should rest; error: the case's
        headline metric. best: is this the engine's fastest setting whose checks hold?
        clocks, workers: as in `harness.study.trial.Trial`. units: rays of a cast, worlds of a step. to_plain: over the plain
        step of the same engine and setting, where something else was clocked. rate [1/s]: units that all processes get done in
        a second of wall time; efficiency: that over `workers` times the rate of one process; where several stepped side by
        side. emulated: the share of the price (0 to 1) that is the adapter's own laws; None where it was not measured.
    """

    case: str
    where: str
    parameters: Mapping[str, Any]
    engine: str
    track: str
    unit: str
    cpu: Interval | None
    to_fastest: Interval | None = None
    reference: Interval | None = None
    reference_setting: str = ""
    penetration: float | None
    residual: float | None
    error: float | None
    error_metric: str
    best: bool = False
    unstable: bool | None
    status: str
    reason: str
    dt: float
    substeps: int
    trial: str
    experiment: str = ""
    clocks: str = "work"
    workers: int = 1
    units: int = 1
    to_plain: Interval | None = None
    rate: float | None = None
    efficiency: Interval | None = None
    emulated: float | None = None

    row = "cost"

    @property
    def answered(self) -> bool:
        """Has it an answer?"""
        return self.status in ("passed", "failed")

    @property
    def beside(self) -> bool:
        """Does it belong to a study of what stands beside the work?"""
        return "clocked" in self.parameters or "workers" in self.parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """Rows of all engines that differ in one numeric parameter, by its size; where: what else tells them from the case.

    Where the parameter decides how many rays or worlds there are, the rows show that number and the price of all of them.
    """

    case: str
    where: str
    unit: str
    parameter: str
    rows: tuple[Cost, ...]


@dataclass(frozen=True, slots=True)
class Exponent:
    """How the price of one engine under one group of settings grows along a sweep: fit: cost = C parameter^order above a floor,
    between two values of the parameter."""

    sweep: Sweep
    engine: str
    track: str
    fit: Order

    row = "exponent"

    @property
    def case(self) -> str:
        """Of the sweep."""
        return self.sweep.case

    @property
    def unit(self) -> str:
        """What is counted."""
        return self.sweep.unit

    @property
    def where(self) -> str:
        """What tells the sweep from the case, and along what it goes."""
        along = f"{called(self.case, self.sweep.parameter)} from {self.fit.fine:g} to {self.fit.coarse:g}"
        return ", ".join(filter(None, (self.sweep.where, along)))

    @property
    def exponent(self) -> tuple[float | None, float, float]:
        """With its interval; None where it is not known well enough."""
        return self.fit.order if self.telling else None, self.fit.low, self.fit.high

    @property
    def telling(self) -> bool:
        """Is the exponent known well enough to be stated? Elsewhere its interval alone is."""
        return self.fit.high - self.fit.low <= TELLING


def growth(sweep: Sweep, rows: Sequence[Cost]) -> Exponent | None:
    """The exponent of the price along a sweep for the rows of one engine; None below three values."""
    points = [(float(row.parameters[sweep.parameter]), row.cpu.value) for row in rows if row.cpu is not None]
    fit = fit_order([x for x, _ in points], [y for _, y in points])
    return None if fit is None else Exponent(sweep, rows[0].engine, rows[0].track, fit)


def whole(sweep: Sweep) -> Sweep:
    """Prices of all rays or worlds together over their number, where that is what the parameter decides."""
    if sweep.unit not in WHOLE or len({row.units for row in sweep.rows}) < FEWEST:
        return sweep
    unit, name = WHOLE[sweep.unit]
    kept = [{n: v for n, v in row.parameters.items() if n != sweep.parameter} for row in sweep.rows]
    rows = [
        replace(row, unit=unit, parameters=others | {name: row.units}, cpu=row.cpu and row.cpu.times(row.units))
        for row, others in zip(sweep.rows, kept, strict=True)
    ]
    return replace(sweep, unit=unit, parameter=name, rows=tuple(sorted(rows, key=lambda row: row.units)))


def no_worse(own: Cost, other: Cost) -> bool:
    """Does one answer penetrate no more and move no more than another (or, where neither is known, err no more)?"""
    names = [name for name in ("penetration", "residual") if getattr(other, name) is not None] or ["error"]
    for name in names:
        mine, theirs = getattr(own, name), getattr(other, name)
        if mine is None or theirs is None or max(mine, SMALLEST[name]) > max(theirs, SMALLEST[name]):
            return False
    return True


_REASON = 64
"""Characters of why a priced run failed; what an engine could not hold comes first, and the whole is in the CSV."""
CLOCKED = SPOKEN["clocked"]
"""What runs under the clock, in the words that set the rows apart."""


class Scaling:
    """The costs and exponents of a run folder, read once."""

    def __init__(self, store: Store) -> None:
        self._store = store
        engines = store.catalogue.get("engines", {})
        self._ours = {name for name, engine in engines.items() if engine.get("ours")}

    @cached_property
    def _samples(self) -> Mapping[str, Mapping[SampledBlock, BlockSample]]:
        return samples_by_block(self._store)

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
        values, cpu = self._store.values(row["trial"]), finite(row.get("cpu_per_unit"))
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
            cpu=None if cpu is None else Interval(cpu, *(finite(row.get(f"cpu_per_unit_{end}")) for end in ("low", "high"))),
            penetration=next((finite(values[name]) for name in PENETRATION if name in values), None),
            residual=next((finite(values[name]) for name in RESIDUAL if name in values), None),
            error=finite(values.get(headline)),
            error_metric=headline,
            unstable=None if pd.isna(unstable) else bool(unstable),
            status=row["status"],
            reason="; ".join([row["reason"], *trouble]) if row["status"] != "passed" else "; ".join(trouble),
            dt=float(row["dt"]),
            substeps=substeps_taken(self._store).get(row["trial"], 1),
            trial=row["trial"],
            experiment=row["experiment"],
            clocks=row.get("clocks", "work"),
            workers=workers,
            emulated=finite(row.get("emulated")),
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

    @property
    def rows(self) -> tuple[Cost | Exponent, ...]:
        """All costs, then all exponents."""
        return (*self.costs, *self.exponents)


def _costs(row: Cost | Exponent) -> str:
    if isinstance(row, Exponent):
        stated = f"{row.fit.order:.2f}" if row.telling else "not known"
        return f"exponent {stated} ({row.fit.low:.2f} to {row.fit.high:.2f})"
    if row.cpu is None:
        return "not clocked" if row.answered else ""
    costs = f"{_micro(row.cpu.value)} us ({'..'.join(map(_micro, row.cpu.ends))})"
    if row.to_plain is not None:
        costs += f", {row.to_plain.value:.3g} x the step alone"
    if row.efficiency is not None:
        costs += f", {row.rate:,.0f} a second, efficiency {row.efficiency.value:.2f}"
    own = share_in_words(row.emulated)
    return f"{costs}, {own}" if own else costs


def _status(row: Cost | Exponent) -> str:
    if isinstance(row, Exponent):
        return ""
    if row.status == "failed" and row.cpu is not None:
        return f"failed: {row.reason[:_REASON]}"
    return row.status if row.answered and row.cpu is not None else f"{row.status}: {row.reason}"


def _millionths(name: str, unit: str) -> Column:
    def cell(row: Cost | Exponent) -> str:
        value = at(row, name)
        return "" if value is None else f"{_micro(value)} {unit}"

    return Column({"penetration": "penetration", "residual": "moves"}[name], cell)


def _micro(value: float) -> str:
    """In millionths, three digits of it, without a power of ten while it is readable."""
    return f"{value * 1e6:,.0f}" if value >= 1e-4 else f"{value * 1e6:.3g}"


def _given(trials: pd.DataFrame) -> list[dict[str, Any]]:
    """The parameters of trials; two more say what was clocked and in how many processes, where that is no plain step."""
    given: list[dict[str, Any]] = [json.loads(text) for text in trials["parameters"]]
    for name, column, as_it_is in (("clocked", "clocks", "work"), ("workers", "workers", 1)):
        if column in trials and (trials[column] != as_it_is).any():
            given = [
                parameters | {name: CLOCKED.get(value, value)} for parameters, value in zip(given, trials[column], strict=True)
            ]
    return given


def _size(value: Any) -> tuple[int, float, str]:
    """Numbers by size, before words by alphabet."""
    return (0, float(value), "") if isinstance(value, int | float) else (1, 0.0, str(value))


scaling_of = once(Scaling)

TABLE = Table(
    # 'cost' rows and 'exponent' rows share the columns; what a row has not is None, and so an exponent not known.
    holds="row case where engine track unit cpu_s(cpu_low_s,cpu_high_s)=cpu to_fastest.. reference.. reference_setting "
    "penetration_m=penetration residual_m_s=residual error error_metric best exponent.. unstable status reason dt substeps "
    "trial clocks workers units to_plain.. rate_per_s=rate efficiency.. emulated",
    objects=lambda store: scaling_of(store).rows,
    shown=(
        Column("scene", scene),
        *plain("engine", "setting=track", "a=unit"),
        Column("costs", _costs),
        Column("x fastest", "to_fastest.value", ".3g"),
        Column(
            "reference x", lambda row: f"{mine.value:.3g} ({row.reference_setting})" if (mine := at(row, "reference")) else ""
        ),
        _millionths("penetration", "um"),
        _millionths("residual", "um/s"),
        # * the engine's fastest whose checks hold, ~ an unstable timing
        Column("marks", lambda row: ("*" if at(row, "best") else "") + ("~" if at(row, "unstable") else "")),
        Column("status", _status),
    ),
)
