"""The searches for limits, read back from a run folder: where each ended, by what it broke, and what a step costs there."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import pandas as pd

from harness.case import Axis
from harness.endure import HELD, STARTS
from harness.limits import Ruler, bracket
from harness.store import Store
from harness.study import Experiment, axis_among, experiment_from

__all__ = ["Search", "amount", "searches"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """One search: a case on an engine under one group of settings.

    Terms:
        where: the parameters, and the time step, that the experiment sets to other values than the case's own. axis, unit,
        easy, extreme: what was made harder. held, broke: the ends of the bracket; None where it has none on that side. share:
        of the members that held at `broke`. signs: by what the others broke. verdict: 'limit', 'beyond the extreme', 'not even
        the easiest', 'stopped' (a run without an answer: `reason`), 'unsupported', 'unavailable'. members: starts of each
        value. values: how many were tried. cost: CPU seconds per simulated second at `held`, roughly. reach: where between easy
        (0) and extreme (1) the limit lies, on the axis's own measure. trial_held, trial_broke: those runs. remedy, remedied:
        what was tried to help the trial that broke.
    """

    experiment: str
    case: str
    where: str
    engine: str
    track: str
    dt: float
    axis: str
    unit: str
    easy: float
    extreme: float
    held: float | None
    broke: float | None
    share: float | None
    signs: str
    verdict: str
    reason: str
    members: int
    values: int
    cost: float | None
    reach: float
    trial_held: str
    trial_broke: str
    remedy: str = ""
    remedied: str = ""


def _experiments(store: Store) -> dict[str, Experiment]:
    sought = [one for one in store.study.get("experiments", ()) if "limit" in one]
    return {one.name: one for one in map(experiment_from, sought)}


def _ruler(store: Store, experiment: Experiment, case: str) -> Ruler:
    told = store.catalogue["cases"][case]
    hard = None if told["hard"] is None else Axis(**told["hard"])
    axis = axis_among(experiment, case, hard, told["ladder"], told["parameters"])
    return Ruler.of(axis, told["parameters"], experiment.limit)


@lru_cache(maxsize=1)
def searches(store: Store) -> tuple[Search, ...]:
    """All searches of a run, those for remedies with them; worked out once for a store."""
    return tuple(_searches(store))


def _searches(store: Store) -> Iterator[Search]:
    experiments = _experiments(store)
    shares, starts = (
        store.measurements[store.measurements["metric"] == name].set_index("trial")["value"] for name in (HELD, STARTS)
    )
    trials = store.trials[store.trials["experiment"].isin(experiments)]
    for (name, case), part in trials.groupby(["experiment", "case"], sort=False):
        by = _ruler(store, experiments[str(name)], str(case))
        told = [json.loads(text) for text in part["parameters"]]
        part = part.assign(
            value=part["dt"] if by.axis.parameter == "dt" else [float(one[by.axis.parameter]) for one in told],
            others=[json.dumps({k: v for k, v in one.items() if k not in (by.axis.parameter, "seed")}) for one in told],
            step=0.0 if by.axis.parameter == "dt" else part["dt"],
        )
        plain = part[part["remedied"] == ""]
        named = _telling(plain["others"], plain["step"], store.catalogue["cases"][str(case)])
        for (others, step, engine, track, remedy, remedied), group in part.groupby(
            ["others", "step", "engine", "track", "remedy", "remedied"], sort=False
        ):
            where = named.get((others, step), "")
            yield _search(str(name), str(case), where, (engine, track), (remedy, remedied), group, by, shares, starts)


def _telling(others: "pd.Series[str]", steps: "pd.Series[float]", case: Mapping[str, Any]) -> dict[tuple[str, float], str]:
    """What tells the cells of an experiment apart, and from the case as it is, in words."""
    cells = list(dict.fromkeys(zip(others, steps, strict=True)))
    told = [json.loads(text) for text, _ in cells]
    own = case["parameters"]
    loose = [name for name in (told[0] if told else {}) if any(one.get(name) != own.get(name) for one in told)]
    many = any(step not in (0.0, case["dt"]) for _, step in cells)
    found = {}
    for cell, one in zip(cells, told, strict=True):
        words = [f"{name} {one[name]}" for name in loose] + ([f"dt 1/{1 / cell[1]:.4g} s"] if many else [])
        found[cell] = ", ".join(words)
    return found


def _search(
    name: str,
    case: str,
    where: str,
    side: tuple[str, str],
    help_: tuple[str, str],
    group: pd.DataFrame,
    by: Ruler,
    shares: "pd.Series[float]",
    starts: "pd.Series[float]",
) -> Search:
    at = {row.value: row for row in group.itertuples()}
    found = bracket({value: row.status for value, row in at.items()}, by)
    held, broke = (None if value is None else at[value] for value in (found.held, found.broke))
    last = max(at.values(), key=lambda row: by.place(row.value))
    reason = last.reason if found.stopped or (broke is None and held is None) else ""
    if broke is not None:
        verdict = "limit" if held is not None else "not even the easiest"
    elif found.stopped:
        verdict = last.status if last.status in ("unsupported", "unavailable") else "stopped"
    else:
        verdict = "beyond the extreme"
    reach = by.place(held.value) if held is not None else 0.0
    return Search(
        experiment=name,
        case=case,
        where=where,
        engine=side[0],
        track=side[1],
        dt=float(last.dt),
        axis=by.axis.parameter,
        unit=by.axis.unit,
        easy=by.axis.easy,
        extreme=by.axis.extreme,
        held=found.held,
        broke=found.broke,
        share=None if broke is None else float(shares.get(broke.trial, 0.0)),
        signs="" if broke is None else _signs(broke),
        verdict=verdict,
        reason=reason,
        members=int(starts.get(last.trial, last.members)),
        values=len(at),
        cost=_number(held.rough_cost if held is not None else None),
        reach=reach,
        trial_held="" if held is None else held.trial,
        trial_broke="" if broke is None else broke.trial,
        remedy=help_[0],
        remedied=help_[1],
    )


def _number(value: float | None) -> float | None:
    return None if value is None or value != value else float(value)


def _signs(row: Any) -> str:
    """'penetration 12, energy 4', or the status of a run that gave no ensemble."""
    return row.reason.partition("broke: ")[2] or f"{row.status}: {row.reason}"


def amount(value: float | None, none: str) -> str:
    """A value in four digits, or a word for none."""
    return none if value is None else f"{value:.4g}"
