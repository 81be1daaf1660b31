"""The agreements of a run folder: each engine's own limit from its runs, judged against the others'."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from plumbline.harness.findings.agreement.judgement import judged
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.scene.file import parse
from plumbline.harness.search.own_limits import ANSWERED, ROUNDING, granted_of, own_limit, rungs_of
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory.parting import NOTHING, extent

AGREED_TRUTH = "agreed limit"
"""What a case says of its truth where engines have to agree on it."""


def scenes_to_judge(store: Store) -> list[str]:
    """The cases of a store whose truth engines have to agree on."""
    tried = set(store.trials["case"])
    return [
        name for name, about in store.catalogue.get("cases", {}).items() if about.get("truth") == AGREED_TRUTH and name in tried
    ]


@lru_cache(maxsize=2)
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
    sides: dict[tuple[str, str], list[Any]] = {}
    for row in rows:
        sides.setdefault((row.engine, row.track), []).append(row)
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
