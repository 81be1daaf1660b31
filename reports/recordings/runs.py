"""Which trials of a case a recording shows, and their arrays cut where they cease to be drawable."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from zipfile import BadZipFile

import numpy as np

from plumbline.harness.store.imported_scenes import looks_of
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.reports.charts.palette import looks
from plumbline.reports.recordings.layout import run_path
from plumbline.reports.recordings.rotation import Floats

LARGEST = 1e30
"""Beyond this [m] a coordinate no longer fits the viewer's single precision with room for a camera."""

STATES = ("p_WB", "q_WB", "v_WB", "w_WB")


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedRun:
    """The trajectory of one engine and track, as far as it is finite.

    Terms:
        path: engine/track. colour: #rrggbb. trial: its row in the table. arrays: as in the store, time (t,) s. note: why the
        end is missing, empty where nothing is.
    """

    path: str
    engine: str
    track: str
    colour: str
    trial: Mapping[str, Any]
    arrays: Mapping[str, Floats]
    note: str = ""

    @property
    def time(self) -> Floats:
        """Instants (t,) s."""
        return self.arrays["time"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """What one recording shows: a scene, the runs in it, and the truth where there is one.

    Terms:
        case: its entry in the catalogue. scene: as in a scene file, empty where no trial left a trajectory. truth: arrays
        time, p_WB, ... and stream:..., empty where there is none. trials: all rows of the case. notes: what
        could not be shown, by trial.
    """

    name: str
    case: Mapping[str, Any]
    scene: Mapping[str, Any] = field(default_factory=dict)
    runs: tuple[RecordedRun, ...] = ()
    truth: Mapping[str, Floats] = field(default_factory=dict)
    trials: tuple[Mapping[str, Any], ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)

    @property
    def length(self) -> float:
        """From the first instant of all runs to the last [s], 0 where there is no run."""
        return max((float(run.time[-1]) for run in self.runs), default=0.0) - min(
            (float(run.time[0]) for run in self.runs), default=0.0
        )

    @property
    def bodies(self) -> list[dict[str, Any]]:
        """The scene's bodies."""
        bodies: list[dict[str, Any]] = self.scene.get("bodies", [])
        return bodies

    @property
    def moving(self) -> Floats:
        """Places of the bodies that are not static."""
        return np.array([k for k, body in enumerate(self.bodies) if body["motion"] != "static"], dtype=np.int64)


def drawable(arrays: Mapping[str, Floats]) -> tuple[int, str]:
    """How many leading instants are finite and in order, and why no more."""
    time = arrays["time"]
    sound = np.isfinite(time)
    for name in STATES:
        values = arrays[name].reshape(len(time), -1)
        sound &= (np.isfinite(values) & (np.abs(values) < LARGEST)).all(axis=1)
    ordered = np.concatenate([[True], np.diff(time) > 0])
    broken = np.flatnonzero(~(sound & ordered))
    if not len(broken):
        return len(time), ""
    first = int(broken[0])
    why = "times out of order" if sound[first] else "a state that is not finite"
    return first, f"shown up to instant {first} of {len(time)}: {why}"


def cut(arrays: Mapping[str, Floats], count: int) -> dict[str, Floats]:
    """States and contacts of the first `count` instants; signals up to that time."""
    kept = {name: array for name, array in arrays.items() if name not in {"time", *STATES} and not name.startswith("contacts_")}
    kept |= {name: arrays[name][:count] for name in ("time", *STATES)}
    if "contacts_count" in arrays:
        lengths = arrays["contacts_count"][:count]
        kept |= {name: array[: int(lengths.sum())] for name, array in arrays.items() if name.startswith("contacts_")}
        kept["contacts_count"] = lengths
    end = kept["time"][-1] if count else -math.inf
    for name in [name for name in kept if name.startswith("stream:")]:
        stamps = arrays[name.rsplit("/", 1)[0] + "/time"]
        kept[name] = arrays[name][stamps <= end * (1 + 1e-12)]
    return kept


def chosen(trials: Sequence[Mapping[str, Any]], case: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """One trial for each engine and track, all of the same parameters and seed, with the case's own dt where there is one."""
    with_states = [t for t in trials if isinstance(t["trajectory_hash"], str)]
    if not with_states:
        return []
    # A scene without its friction, or from another start, is not the case's: it is shown only where nothing else is there.
    with_states = [t for t in with_states if '"name"' not in str(t.get("alteration", ""))] or with_states
    own = case.get("parameters", {})

    def variant(trial: Mapping[str, Any]) -> tuple[str, int]:
        return trial["parameters"], int(trial["seed"])

    def engines_with(key: tuple[str, int]) -> int:
        return len({(t["engine"], t["track"]) for t in with_states if variant(t) == key})

    shown = min(
        dict.fromkeys(variant(t) for t in with_states),
        key=lambda key: (json.loads(key[0]) != own, -engines_with(key), key[1]),
    )
    wanted = case.get("dt") or min(t["dt"] for t in with_states)
    picked: dict[tuple[str, str], Mapping[str, Any]] = {}
    for trial in sorted(
        (t for t in with_states if variant(t) == shown), key=lambda t: round(abs(math.log(t["dt"] / wanted)), 9)
    ):
        picked.setdefault((trial["engine"], trial["track"]), trial)
    return list(picked.values())


def touching(stage: Stage) -> bool:
    """Has some run contacts to draw?"""
    return any("contacts_count" in run.arrays for run in stage.runs)


def stage_of(store: Store, name: str) -> Stage:
    """All that the recording of a case shows."""
    case = store.catalogue.get("cases", {}).get(name, {})
    trials, met = store.tried.get(name, ()), store.trials["engine"].unique()
    engines = list(store.catalogue.get("engines", {})) or sorted(set(met))
    colours = looks(dict.fromkeys([*engines, *met]))
    order = {engine: rank for rank, engine in enumerate(colours)}
    runs: list[RecordedRun] = []
    notes: dict[str, str] = {}
    for trial in sorted(chosen(trials, case), key=lambda t: (order[t["engine"]], t["track"] != "tuned", t["track"])):
        try:
            arrays = store.trajectory(trial["trajectory_hash"])
            count, note = drawable(arrays)
        except (StoreError, BadZipFile, KeyError) as error:
            notes[trial["trial"]] = f"not shown: trajectory {trial['trajectory_hash']} is not readable: {error}"
            continue
        if note:
            notes[trial["trial"]] = note
        runs.append(
            RecordedRun(
                path=run_path(trial["engine"], trial["track"]),
                engine=trial["engine"],
                track=trial["track"],
                colour=colours[trial["engine"]].colour,
                trial=trial,
                arrays=cut(arrays, count),
                note=note,
            )
        )
    scene = dressed(json.loads(str(runs[0].arrays["scene"])), looks_of(store.folder, name)) if runs else {}
    return Stage(
        name=name,
        case=case,
        scene=scene,
        runs=tuple(run for run in runs if len(run.time)),
        truth=_truth(runs),
        trials=tuple(trials),
        notes=notes,
    )


def dressed(scene: dict[str, Any], drawn: Mapping[str, Any]) -> dict[str, Any]:
    """A scene whose bodies look as their robot's file says."""
    for body in scene.get("bodies", []):
        if body["name"] in drawn:
            body["visual"] = drawn[body["name"]]
    return scene


def _truth(runs: list[RecordedRun]) -> dict[str, Floats]:
    """The longest truth among the runs; all of them are about the same scene."""
    truths = [run.arrays for run in runs if "truth_time" in run.arrays]
    if not truths:
        return {}
    longest = max(truths, key=lambda arrays: len(arrays["truth_time"]))
    return {name.removeprefix("truth_"): array for name, array in longest.items() if name.startswith("truth_")}
