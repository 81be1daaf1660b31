"""Whether answers converge as their integrators promise: the rows of the orders table, made from a run folder.

The adapter says what each of its integrators promises for smooth motion, the case whether its headline can show that: where
contacts begin or end within a step, the first order is left of any promise.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import itemgetter
from statistics import median
from typing import Any, Literal

import pandas as pd

from plumbline.harness.findings.columns import Cell, Column, Table, bracketed, plain
from plumbline.harness.findings.once import all_once
from plumbline.harness.findings.parameter_words import in_words, integrator_called, other_values
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import Order, falls_short, fit_order
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store

OrderVerdict = Literal["kept", "broken", "exact", "open", "none"]

ROUNDINGS = 8
"""Roundings of the scale in each step, all to one side, that an error may consist of."""
SMALLEST = 1e-12
"""Share of the scale below which series and integrators behind the truths hold no more digits."""


_READ = ["trial", "case", "parameters", "engine", "track", "dt", "resolved"]
"""Columns of a trial that are read here; to group the others along costs ten times as much."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ObservedOrder(Cell):
    """How the headline error of a case shrinks with the time step on one engine under one group of settings.

    Terms:
        where: parameters, in words, if not the case's own. fit: of that error, None without one. promised: None where nothing
        is. verdict: kept; broken; exact: the error is nowhere above what numbers of 64 bits leave; open: too few steps to tell;
        none: nothing is promised. finding: a sentence where the promise is broken.
    """

    metric: str
    integrator: str
    fit: Order | None
    promised: int | None
    verdict: OrderVerdict
    finding: str

    @property
    def used(self) -> int:
        """Steps that the fit goes through."""
        return 0 if self.fit is None else self.fit.used


@all_once
def convergences(store: Store) -> list[ObservedOrder]:
    """One row for each ladder of at least three steps, experiments that share settings taken together."""
    cases, engines = store.catalogue.get("cases", {}), store.catalogue.get("engines", {})
    if store.asked.empty:
        return []
    trials = store.asked.loc[store.asked["status"].isin(("passed", "failed")), _READ]
    headlines = {name: case.get("headline", "") for name, case in cases.items()}
    table = store.measurements
    values = dict(zip(zip(table["trial"], table["metric"], strict=True), table["value"], strict=True))
    errors = [values.get((trial, headlines.get(case, ""))) for trial, case in zip(trials["trial"], trials["case"], strict=True)]
    trials = trials.assign(error=pd.Series(errors, index=trials.index, dtype="float64").abs()).dropna(subset="error")
    rows = []
    keys = [trials["case"], trials["parameters"].map(_seedless), trials["engine"], trials["track"]]
    rungs = map(_Rung, trials["dt"].tolist(), trials["error"].tolist(), trials["resolved"].tolist())
    keyed = zip(zip(*keys, strict=True), rungs, strict=True)
    for (case, parameters, engine, track), pairs in grouped(keyed, itemgetter(0)).items():
        ladder = [rung for _, rung in pairs]
        if len({rung.dt for rung in ladder}) >= 3:
            about = cases.get(case, {})
            where = in_words(other_values(_object(str(parameters)), about.get("parameters") or {}))
            cell = Cell(case=str(case), where=where, engine=str(engine), track=str(track))
            rows.append(_row(cell, about, engines.get(engine, {}), ladder))
    return rows


@dataclass(frozen=True, slots=True)
class _Rung:
    """A trial of a ladder. Terms: dt [s]. error: of its headline. resolved: what the engine said it used, as JSON."""

    dt: float
    error: float
    resolved: str


@lru_cache(maxsize=4096)
def _object(text: str) -> Mapping[str, Any]:
    """A JSON object; nothing where an old or broken store holds something else."""
    try:
        value = json.loads(text)
    except (TypeError, ValueError):
        return {}
    return value if isinstance(value, dict) else {}


def _seedless(parameters: str) -> str:
    return json.dumps({k: v for k, v in _object(parameters).items() if k != "seed"}, sort_keys=True)


def _row(cell: Cell, about: Mapping[str, Any], who: Mapping[str, Any], ladder: Sequence[_Rung]) -> ObservedOrder:
    integrators = sorted({str(_object(rung.resolved).get("integrator") or "") for rung in ladder})
    promised = _promise(about.get("converges", ""), who.get("orders", {}), integrators)
    by_step = grouped(zip(_taken(ladder), ladder, strict=True), itemgetter(0))
    steps = sorted(by_step)
    errors = [median(rung.error for _, rung in by_step[dt]) for dt in steps]
    scale, duration = float(about.get("scale") or 1.0), float(about.get("duration") or 1.0)
    fit, outcome = verdict(steps, errors, promised, scale, duration)
    by = " and ".join(map(integrator_called, integrators))
    title = f"{about.get('title') or cell.case} on {who.get('title') or cell.engine} ({cell.track}, {by})"
    return ObservedOrder(
        **cell.cell,
        metric=str(about.get("headline", "")),
        integrator=" ".join(integrators),
        fit=fit,
        promised=promised,
        verdict=outcome,
        finding="" if outcome != "broken" or fit is None or promised is None else _sentence(title, fit, promised, errors[0]),
    )


def _taken(ladder: Sequence[_Rung]) -> list[float]:
    """The steps [s] of a ladder as the engine took them, told in steps of its finest rung.

    An engine that cuts coarse steps into sub-steps takes the same step on several rungs: these are one point of the slope.
    """
    substeps = [float(_object(rung.resolved).get("substeps") or 1) for rung in ladder]
    finest = substeps[min(range(len(ladder)), key=lambda k: ladder[k].dt)]
    # 1/60 s in 4 and 1/240 s in 1 are one step, whatever the last digit says.
    return [float(f"{rung.dt * finest / parts:.12g}") for rung, parts in zip(ladder, substeps, strict=True)]


def _promise(converges: str, orders: Mapping[str, int], integrators: Sequence[str]) -> int | None:
    """The least that any of the integrators used promises, and at most the first order where contacts come and go."""
    if not converges or not integrators or not all(name in orders for name in integrators):
        return None
    least = min(orders[name] for name in integrators)
    return least if converges == "smoothly" else min(1, least)


def verdict(
    steps: Sequence[float], errors: Sequence[float], promised: int | None, scale: float, duration: float
) -> tuple[Order | None, OrderVerdict]:
    """The fit through what lies above rounding, and what it says of the promise.

    Args:
        steps [s], errors: shape (n,), one each. scale: the error that counts as 1. duration [s]: of a run.
    """
    least = [scale * max(SMALLEST, ROUNDINGS * 2.0**-52 * duration / dt) for dt in steps]
    above = [
        (dt, error) for dt, error, low in zip(steps, errors, least, strict=True) if error > low or not math.isfinite(error)
    ]
    if not above:
        return None, "exact"
    fit = fit_order([dt for dt, _ in above], [error for _, error in above])
    if promised is None:
        return fit, "none"
    if fit is None:
        return None, "open"
    return fit, "broken" if falls_short(fit, promised) else "kept"


def _sentence(title: str, fit: Order, promised: int, finest: float) -> str:
    if fit.floor is not None and fit.left > 0.5:
        return (
            f"{title}: below a step of {1e3 * fit.fine:.3g} ms the error stays at {fit.floor:.2g}, {fit.left:.0%} of its "
            f"largest value; above, it shrinks with order {fit.order:.2f} ({fit.low:.2f} to {fit.high:.2f}), promised is "
            f"{promised}."
        )
    goes = f"shrinks with order {fit.order:.2f}" if fit.order > 0 else f"grows as the step shrinks, with order {fit.order:.2f}"
    return (
        f"{title}: the error {goes} ({fit.low:.2f} to {fit.high:.2f}) from a step of "
        f"{1e3 * fit.coarse:.3g} to {1e3 * fit.fine:.3g} ms, promised is {promised}; at the finest step it is {finest:.2g}."
    )


TABLE = Table(
    holds="case where engine track metric integrator order=fit.order low=fit.low high=fit.high used floor=fit.floor "
    "coarse=fit.coarse fine=fit.fine promised verdict finding",
    objects=convergences,
    shown=(
        *plain("case", "engine", "track", "integrator", "promised=promised:d", "order=fit.order:.2f"),
        Column("interval", lambda row: bracketed(row.fit and Interval(row.fit.order, row.fit.low, row.fit.high), ".2f")),
        *plain("floor=fit.floor:.2g", "verdict"),
    ),
    sentences=lambda rows: [row.finding for row in rows if row.finding],
)
