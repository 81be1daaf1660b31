"""The searches for limits, read back from a run folder: where each ended, by what it broke, and what a step costs there."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from plumbline.harness.case import Axis
from plumbline.harness.findings.once import all_once
from plumbline.harness.findings.parameter_words import STEP, differing, in_words
from plumbline.harness.search.first_break import BROKE, Bracket, ErrorAt, Ruler, bracket, unchanged
from plumbline.harness.store.record import StoredNotice
from plumbline.harness.store.rows import finite
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Experiment, axis_among, experiments_of
from plumbline.harness.trial.ensemble import BROKE_BY, HEADLINE, HELD, OWN_CHECKS, STARTS

CONSTANT = "no limit"
"""The verdict where the headline error is as large at the extreme as at the easy end: its bar is crossed by a constant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """A value that held. Terms: reach: its place between easy (0) and extreme (1); further: that of the next harder value that
    was tried, its own where none was. cost: CPU seconds for one time step of the case, roughly, None where unknown."""

    value: float
    reach: float
    further: float
    cost: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Signs:
    """By what a value broke. Terms: counts: how many starts each metric of the case's limit counts against, most first; status,
    reason: of a run that gave no ensemble."""

    counts: tuple[tuple[str, int], ...] = ()
    status: str = ""
    reason: str = ""

    @property
    def brief(self) -> str:
        """'penetration 12, energy 4', or the status alone; '' where nothing broke."""
        return ", ".join(f"{metric} {count}" for metric, count in self.counts) or self.status

    @property
    def text(self) -> str:
        """The same, with the reason of a run that gave no ensemble."""
        return f"{self.status}: {self.reason}" if self.status and not self.counts else self.brief


BesideValues = tuple[tuple[str, Any], ...]
"""Parameters with their values, and the time step [s] by the name `STEP`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """One search: a case on an engine under one group of settings.

    Terms:
        beside: the parameters, and the time step [s], that the experiment sets to other values than the case's own, each with
        its value. where: the same in words. axis, unit,
        easy, extreme: what was made harder. held, broke: the ends of the bracket; None where it has none on that side. share:
        of the members that held at `broke`. signs: by what the others broke. verdict: 'limit', CONSTANT, 'beyond the extreme',
        'not even the easiest', 'stopped' (no answer: `reason`), 'unsupported', 'unavailable'. members: starts of each
        value. values: how many were tried. cost: CPU seconds per simulated second at `held`, roughly. reach: where between easy
        (0) and extreme (1) the limit lies, on the axis's own measure. trial_held, trial_broke: those runs. remedy, remedied:
        what was tried to help the trial that broke. dt [s]: the time step that is divided. parts: what it was to be taken in, 0
        where that was left to the track. substep [s]: the finest step that the engine really took, None without an answer.
        step_cost: CPU seconds for one such time step at `held`, roughly. holds: all that held before the first that broke, the
        hardest last. own_holds: do the case's checks hold at `broke` at its own start, so that others broke? None without an
        answer. noticed: what the engine warned of there: effects that the scene does not call for, or that it lacks. along: the
        headline error at each value that was tried, from easy to extreme; empty where no axis is about it.
    """

    experiment: str
    case: str
    where: str
    beside: BesideValues
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
    signs: Signs
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
    parts: int = 0
    substep: float | None = None
    step_cost: float | None = None
    holds: tuple[Hold, ...] = ()
    own_holds: bool | None = None
    noticed: tuple[StoredNotice, ...] = ()
    along: tuple[ErrorAt, ...] = ()

    @property
    def along_in_words(self) -> str:
        """'0.167 at 1, 0.333 at 1e+06; bar 0.3': the ends; '' where no axis is about an error."""
        if not self.along:
            return ""
        ends = dict.fromkeys((self.along[0], self.along[-1]))
        return ", ".join(f"{end.error:.3g} at {end.value:.4g}" for end in ends) + f"; bar {self.along[-1].bar:.3g}"

    @property
    def noticed_in_words(self) -> str:
        """All that the engine warned of."""
        return "; ".join(map(str, self.noticed))

    @property
    def setting(self) -> str:
        """The track, with the sub-step that it was held to."""
        if not self.parts:
            return self.track
        return f"{self.track}, sub-step dt" + (f"/{self.parts}" if self.parts > 1 else "")

    @property
    def further(self) -> float:
        """Where between easy and extreme the next harder value lies that was tried; `reach` where none was."""
        return max(self.reach, self.holds[-1].further) if self.holds else self.reach

    @property
    def searched_along(self) -> tuple[str, str, str]:
        """What searches that can be compared have in common: experiment, case and where."""
        return self.experiment, self.case, self.where

    @property
    def fair(self) -> bool:
        """Was the engine held to the sub-step that was asked for, or to a coarser one?"""
        return self.substep is None or not self.parts or self.substep * self.parts >= self.dt * (1 - 1e-9)


def _ruler(store: Store, experiment: Experiment, case: str) -> Ruler:
    about = store.described("cases", case)
    hard = None if about["hard"] is None else Axis(**about["hard"])
    axis = axis_among(experiment, case, hard, about["ladder"], about["parameters"])
    return Ruler.of(axis, about["parameters"], experiment.limit)


def searches_if_described(store: Store) -> tuple[Search, ...]:
    """The same for pages that are not about limits alone: none where the folder has lost the catalogue, which says the axes."""
    return searches(store) if store.catalogue else ()


def _readings(store: Store, trial: str) -> Mapping[str, Mapping[str, Any]]:
    """What was measured of a trial, by metric."""
    return {row["metric"]: row for row in store.measured.get(trial, ())}


@all_once
def searches(store: Store) -> Iterator[Search]:
    """All searches of a run, those for remedies with them."""
    experiments = {experiment.name: experiment for experiment in experiments_of(store) if experiment.limit is not None}
    if not experiments:
        return
    trials = store.trials[store.trials["experiment"].isin(experiments)]
    for (name, case), mine in trials.groupby(["experiment", "case"], sort=False):
        by = _ruler(store, experiments[str(name)], str(case))
        parameters = [json.loads(text) for text in mine["parameters"]]
        mine = mine.assign(
            value=mine["dt"] if by.axis.parameter == "dt" else [float(given[by.axis.parameter]) for given in parameters],
            others=[
                json.dumps({k: v for k, v in given.items() if k not in (by.axis.parameter, "seed")}) for given in parameters
            ],
            outer=_outer(mine),
        )
        mine = mine.assign(step=0.0 if by.axis.parameter == "dt" else mine["outer"])
        plain = mine[mine["remedied"] == ""]
        beside = _beside(plain["others"], plain["step"], store.described("cases", str(case)))
        for (others, step, engine, track, parts, remedy, remedied), group in mine.groupby(
            ["others", "step", "engine", "track", "parts", "remedy", "remedied"], sort=False
        ):
            side = (engine, track, int(parts))
            yield _search(store, str(name), str(case), beside.get((others, step), ()), side, (remedy, remedied), group, by)


def _outer(trials: pd.DataFrame) -> list[float]:
    """The time step [s] of each trial that its parts are parts of: an engine without sub-steps was told one of these."""
    settings = [json.loads(text) for text in trials["settings"]]
    return [
        float(dt) if not parts else float(dt) / (setting.get("substeps") or 1) * parts
        for dt, parts, setting in zip(trials["dt"], trials["parts"], settings, strict=True)
    ]


def _beside(
    others: "pd.Series[str]", steps: "pd.Series[float]", case: Mapping[str, Any]
) -> dict[tuple[str, float], BesideValues]:
    """What tells the cells of an experiment apart, and from the case as it is."""
    cells = list(dict.fromkeys(zip(others, steps, strict=True)))
    parameters = [json.loads(text) for text, _ in cells]
    loose = differing(parameters, case["parameters"])
    many = any(step not in (0.0, case["dt"]) for _, step in cells)
    return {
        cell: tuple((name, values[name]) for name in loose) + (((STEP, float(cell[1])),) if many else ())
        for cell, values in zip(cells, parameters, strict=True)
    }


def _search(
    store: Store,
    name: str,
    case: str,
    beside: BesideValues,
    side: tuple[str, str, int],
    help_: tuple[str, str],
    group: pd.DataFrame,
    by: Ruler,
) -> Search:
    at = {row.value: row for row in group.itertuples()}
    interval = bracket({value: row.status for value, row in at.items()}, by)
    held, broke = (None if value is None else at[value] for value in (interval.held, interval.broke))
    last = max(at.values(), key=lambda row: by.place(row.value))
    reason = last.reason if interval.stopped or (broke is None and held is None) else ""
    tried = sorted(at, key=by.place)
    worst = [(value, _readings(store, at[value].trial).get(HEADLINE)) for value in tried]
    along = tuple(ErrorAt(value, float(row["value"]), float(row["at_most"])) for value, row in worst if row is not None)
    broken, starts = {} if broke is None else _readings(store, broke.trial), _readings(store, last.trial).get(STARTS)
    if broke is not None and unchanged(along, by.axis.easy, by.axis.extreme):
        verdict = CONSTANT
    elif broke is not None:
        verdict = "limit" if held is not None else "not even the easiest"
    elif interval.stopped:
        verdict = last.status if last.status in ("unsupported", "unavailable") else "stopped"
    else:
        verdict = "beyond the extreme"
    reach = by.place(held.value) if held is not None else 0.0
    holds = _holds(at, interval, by)
    taken = [float(row.substep) for row in at.values() if row.substep == row.substep]
    return Search(
        experiment=name,
        case=case,
        where=in_words(beside),
        beside=beside,
        engine=side[0],
        track=side[1],
        dt=float(last.outer),
        axis=by.axis.parameter,
        unit=by.axis.unit,
        easy=by.axis.easy,
        extreme=by.axis.extreme,
        held=interval.held,
        broke=interval.broke,
        share=None if broke is None else float(broken[HELD]["value"]) if HELD in broken else 0.0,
        signs=Signs() if broke is None else _signs(broke, broken),
        verdict=verdict,
        reason=reason,
        members=int(last.members if starts is None else starts["value"]),
        values=len(at),
        cost=finite(held.rough_cost if held is not None else None),
        reach=reach,
        trial_held="" if held is None else held.trial,
        trial_broke="" if broke is None else broke.trial,
        remedy=help_[0],
        remedied=help_[1],
        parts=side[2],
        substep=min(taken, default=None),
        step_cost=holds[-1].cost if holds else None,
        holds=holds,
        own_holds=bool(broken[OWN_CHECKS]["value"]) if OWN_CHECKS in broken else None,
        noticed=() if broke is None else tuple(notice for notice in store.notices[broke.trial] if notice.kind != "note"),
        along=along,
    )


def _holds(at: Mapping[float, Any], interval: Bracket, by: Ruler) -> tuple[Hold, ...]:
    """What held before the first value that broke, each with its cost and with the next harder value that was tried."""
    tried = sorted(at, key=by.place)
    made = []
    for value, harder in zip(tried, [*tried[1:], tried[-1]], strict=True):
        if at[value].status != "passed" or (interval.broke is not None and by.place(value) >= by.place(interval.broke)):
            continue
        answered = at[harder].status in ("passed", *BROKE)
        cost = finite(at[value].rough_cost)
        made.append(
            Hold(
                value=value,
                reach=by.place(value),
                further=by.place(harder if answered else value),
                cost=None if cost is None else cost * float(at[value].outer),
            )
        )
    return tuple(made)


def _signs(row: Any, readings: Mapping[str, Mapping[str, Any]]) -> Signs:
    shares = {name: reading["value"] for name, reading in readings.items() if name.startswith(BROKE_BY)}
    counts = {name.removeprefix(BROKE_BY): round(share * readings[STARTS]["value"]) for name, share in shares.items()}
    return Signs(
        counts=tuple(sorted(counts.items(), key=lambda sign: -sign[1])), status=str(row.status), reason=str(row.reason)
    )


def amount(value: float | None, none: str) -> str:
    """A value in four digits, or a word for none."""
    return none if value is None else f"{value:.4g}"
