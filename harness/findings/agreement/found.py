"""The agreements of a run folder, each engine's own limit from its runs judged against the others', and the error of every run.

A run errs by its distance from the agreed limit, or from its engine's own where none is: so what an engine errs at a step
stands beside what that step costs, as in a case whose truth is known. Distances are the largest up to the time to which the
limit is known, as shares of the size of what moves.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from plumbline.harness.findings.agreement.judgement import judged
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.once import once
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.scene.file import parse
from plumbline.harness.search.own_limits import ANSWERED, ROUNDING, granted_of, own_limit, rungs_of
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.parting import NOTHING, apart, common, extent

AGREED_TRUTH = "agreed limit"
"""What a case says of its truth where engines have to agree on it."""


def scenes_to_judge(store: Store) -> list[str]:
    """The cases of a store whose truth engines have to agree on."""
    tried = set(store.trials["case"])
    return [
        name for name, about in store.catalogue.get("cases", {}).items() if about.get("truth") == AGREED_TRUTH and name in tried
    ]


@once
def agreements(store: Store) -> tuple[Agreement, ...]:
    """One for each scene without a truth, at each set of its parameters."""
    results = []
    for case in scenes_to_judge(store):
        rows = store.asked[store.asked["case"] == case]
        refined = rows[rows["experiment"].isin(_ladders(store))] if len(_ladders(store)) else rows
        for parameters, group in (refined if len(refined) else rows).groupby("parameters", sort=False):
            results.append(_agreement(store, case, "" if parameters == "{}" else str(parameters), list(group.itertuples())))
    return tuple(results)


def _ladders(store: Store) -> list[str]:
    """The experiments that went on halving: others run a step or two of a scene for ends of their own."""
    return [str(experiment.get("name")) for experiment in _refining(store)]


def _refining(store: Store) -> list[dict[str, Any]]:
    experiments = store.study.get("experiments", [])
    listed = experiments if isinstance(experiments, list) else []
    return [experiment for experiment in listed if isinstance(experiment, dict) and experiment.get("refine")]


def _finest(store: Store) -> tuple[float, float]:
    """The step [s] that ladders are to come down to, and that of a limit that is not known to the end; 0 where none is said."""
    refined = [experiment["refine"] for experiment in _refining(store)]
    finest = min((float(each.get("finest") or 0.0) for each in refined), default=0.0)
    return finest, finest / 2 ** max((int(each.get("further") or 0) for each in refined), default=0)


def _agreement(store: Store, case: str, where: str, rows: Sequence[Any]) -> Agreement:
    scene = _scene(store, rows)
    sides = grouped(rows, attrgetter("engine", "track"))
    scale = NOTHING if scene is None else extent(scene)
    engines = store.catalogue.get("engines", {})
    touching = scene is not None and Effect.CONTACT in scene.effects and _touching(store, rows)
    granted = ROUNDING if scene is None else granted_of(scene, scale, touching=touching)
    limits = {
        side: own_limit(scale, rungs_of(store, runs), engines.get(side[0], {}).get("orders"), granted)
        for side, runs in sides.items()
    }
    ours = [name for name, engine in engines.items() if engine.get("ours")]
    duration = float(store.described("cases", case)["duration"])
    agreement = judged(scene, duration, limits, ours, touching=touching, case=case, where=where)
    with_effects = tuple(replace(side, adds=_added(store, side)) for side in agreement.sides)
    finest, finest_unknown = _finest(store)
    return replace(agreement, sides=with_effects, finest=finest, finest_unknown=finest_unknown)


def _added(store: Store, side: Side) -> tuple[str, ...]:
    """The effects that the finest answer of a side computes although its scene does not call for them, by its own word."""
    notices = () if side.limit.finest is None else store.notices.get(side.limit.finest.trial, ())
    return tuple(dict.fromkeys(each.effect.replace("_", " ") for each in notices if each.kind == "surplus" and each.effect))


def _touching(store: Store, rows: Sequence[Any]) -> bool:
    """Does the finest run of any engine and track list a contact?"""
    finest: dict[tuple[str, str], Any] = {}
    for row in sorted(rows, key=lambda row: -row.dt):
        if row.status in ANSWERED and isinstance(row.trajectory_hash, str):
            finest[row.engine, row.track] = row
    kept = (store.trajectory(row.trajectory_hash) for row in finest.values())
    return any(bool(np.any(arrays.get("contacts_count", 0))) for arrays in kept)


def _scene(store: Store, rows: Sequence[Any]) -> Scene | None:
    """The scene as it was put to the engines, from the first run that kept one, diverged or not."""
    for row in rows:
        if isinstance(row.trajectory_hash, str):
            return parse(str(store.trajectory(row.trajectory_hash, ("scene",))["scene"]), "scene.json")
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Of one run. Terms: error, and how far off the limit itself may be (off), as shares of the size; agreed: is the limit that
    of several engines, or the engine's own? until [s]: up to there it is compared."""

    error: float
    off: float
    agreed: bool
    until: float


@once
def errors_of(store: Store) -> Mapping[str, Errors]:
    """By trial; runs without an answer, and engines without a limit, have none."""
    errors: dict[str, Errors] = {}
    for agreement in agreements(store):
        for side in agreement.sides:
            errors |= _of_side(agreement, side)
    return errors | _of_equal_runs(store, errors)


def _of_equal_runs(store: Store, errors: Mapping[str, Errors]) -> dict[str, Errors]:
    """Of runs that other experiments made of the same scene, with the same bits."""
    asked = store.asked[store.asked["case"].isin({agreement.case for agreement in agreements(store)})]
    by_motion = {row.trajectory_hash: errors[row.trial] for row in asked.itertuples() if row.trial in errors}
    return {
        row.trial: by_motion[row.trajectory_hash]
        for row in asked.itertuples()
        if row.trial not in errors and row.trajectory_hash in by_motion
    }


def _of_side(agreement: Agreement, side: Side) -> dict[str, Errors]:
    if agreement.limit is not None and agreement.bar is not None:
        limit, off, until = agreement.limit, agreement.bar, agreement.until
    elif side.limit.value is not None and side.limit.until > 0:
        limit, off, until = side.limit.value, side.limit.bar_at(side.limit.until), side.limit.until
    else:
        return {}
    errors = {}
    for rung in side.limit.rungs:
        if rung.run is not None:
            here, there = common([rung.run.between(0.0, until), limit.between(0.0, until)])
            # A run that is the limit itself, where no order shows, errs by what that is known to and not by nothing.
            error = float(apart(here, there, agreement.scale).max(initial=0.0)) or off
            errors[rung.trial] = Errors(error=error, off=off, agreed=agreement.limit is not None, until=until)
    return errors


def ways(agreement: Agreement) -> tuple[str, Mapping[tuple[str, str], tuple[Floats, Floats]]]:
    """How far each limit has been, up to each sample, from the one that is agreed; where none is, from that known longest.

    Returns: 'engine, track' of the limit that is measured from, '' for the agreed one; and by engine and track the times (t,)
    s and the distances (t,), as shares of the size.
    """
    sides = [side for side in agreement.sides if side.limit.value is not None and side.limit.until > 0]
    if not sides:
        return "", {}
    first = max(sides, key=lambda side: side.limit.until)
    base, until = (agreement.limit, agreement.until) if agreement.limit is not None else (first.limit.value, first.limit.until)
    assert base is not None
    distances = {}
    for side in sides:
        assert side.limit.value is not None
        end = min(until, side.limit.until)
        here, there = common([side.limit.value.between(0.0, end), base.between(0.0, end)])
        distances[side.engine, side.track] = (here.time, np.maximum.accumulate(apart(here, there, agreement.scale)))
    return "" if agreement.limit is not None else f"{first.engine}, {first.track}", distances
