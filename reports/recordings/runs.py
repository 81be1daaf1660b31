"""Which trials of a case a recording shows, and their arrays cut where they cease to be drawable.

Which instants a recording shows: as many as a viewer has frames for while it plays the case.

A case plays over `WATCH`, at `FRAMES` a second. What a trajectory holds between two frames is never seen; the stretch about a
moment plays over as long, and so shows what the whole case leaves out.

Who tells a signal: an engine's run or the truth, with its colour and its name.

Where a sensor is at its readings: the pose of the body that carries it, composed with its own.
"""

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
from plumbline.reports.charts.marks import looks
from plumbline.reports.recordings.layout import GHOST, TRUTH, Floats, Rgba, compose, rgba, run_path

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
        dict.fromkeys(variant(t) for t in with_states), key=lambda key: (json.loads(key[0]) != own, -engines_with(key), key[1])
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


WATCH = 6.0, 20.0
"""Seconds that a case takes to play, at least and at most: a bullet is slowed down, a long wait made short."""

FRAMES = 60
"""A second, of the viewer."""


def playing_time(length: float) -> float:
    """Seconds that so much simulated time [s] takes to play."""
    return min(max(length, WATCH[0]), WATCH[1])


def stride_of(time: Floats, length: float) -> int:
    """Each how many-th instant `time` (t,) s of a run is shown, in a case of this length [s]: no fewer than frames."""
    passed = float(time[-1] - time[0]) if len(time) else 0.0
    if not (passed > 0 and length > 0):
        return 1
    instants_a_frame = (len(time) - 1) / passed * length / (FRAMES * playing_time(length))
    return max(1, int(instants_a_frame * (1 + 1e-9)))


def shown(time: Floats, length: float) -> Floats:
    """Places of the instants that are shown, the first and the last among them."""
    places = np.arange(0, len(time), stride_of(time, length))
    return places if not len(time) or places[-1] == len(time) - 1 else np.append(places, len(time) - 1)


def extremes(values: Floats, stride: int) -> Floats:
    """Places that a curve of values (k,) is drawn through, one for `stride` of them: no peak and no dip is left out.

    Of each stretch of twice that many, the smallest and the largest; the first and the last besides.
    """
    if stride == 1 or len(values) <= 2 * stride:
        return np.arange(len(values))
    whole = len(values) // (2 * stride) * 2 * stride
    blocks = values[:whole].reshape(-1, 2 * stride)
    first = np.arange(0, whole, 2 * stride)
    rest = np.arange(whole, len(values))
    ends = np.array([0, len(values) - 1])
    return np.unique(np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1), rest, ends]))


def at_instants(arrays: Mapping[str, Floats], places: Floats) -> dict[str, Floats]:
    """States and contacts of the instants at these places, in order; all else as it is."""
    time = arrays["time"]
    chosen = dict(arrays) | {name: arrays[name][places] for name in ("time", *STATES) if name in arrays}
    if "contacts_count" in arrays:
        counts = np.asarray(arrays["contacts_count"], dtype=np.int64)
        kept = np.zeros(len(time), dtype=bool)
        kept[places] = True
        rows = np.repeat(kept, counts)
        chosen |= {
            name: array[rows] for name, array in arrays.items() if name.startswith("contacts_") and len(array) == len(rows)
        }
        chosen["contacts_count"] = counts[kept]
    return chosen


@dataclass(frozen=True, slots=True)
class Source:
    """One teller of signals.

    Terms:
        path: its part of a path. arrays: as in the store. truth: is it the truth, which tells of ideal signals only?
    """

    path: str
    name: str
    arrays: Mapping[str, Floats]
    colour: Rgba
    truth: bool = False

    def signal(self, sensor: str, channel: str) -> Floats | None:
        """What was read, by the truth what should have been; None where it was not recorded."""
        plain, ideal = f"stream:{sensor}/{channel}", f"stream:{sensor}/{channel}_ideal"
        first, other = (ideal, plain) if self.truth else (plain, ideal)
        signal = self.arrays.get(first, self.arrays.get(other))
        return signal if signal is not None and len(signal) and f"stream:{sensor}/time" in self.arrays else None

    def stamps(self, sensor: str) -> Floats:
        """The times [s] of a sensor's readings."""
        return self.arrays[f"stream:{sensor}/time"]


def sources(stage: Stage) -> list[Source]:
    """All runs of a stage, then its truth."""
    runs = [Source(run.path, f"{run.engine} {run.track}", run.arrays, rgba(run.colour)) for run in stage.runs]
    return [*runs, Source(TRUTH, "truth", stage.truth, (*GHOST[:3], 255), truth=True)]


def mounted(stage: Stage, sensor: Mapping[str, Any], arrays: Mapping[str, Floats], time: Floats) -> tuple[Floats, Floats]:
    """p_WS (k, 3) m and q_WS (k, 4) of a sensor at its readings, from the state nearest in time."""
    p_BS, q_BS = np.asarray(sensor["p_BS"]), np.asarray(sensor["q_BS"])
    carrier = next((k for k, body in enumerate(stage.bodies) if body["name"] == sensor["body"]), None)
    if carrier is None:
        return np.broadcast_to(p_BS, (len(time), 3)), np.broadcast_to(q_BS, (len(time), 4))
    states = arrays["time"]
    after = np.clip(np.searchsorted(states, time), 1, max(len(states) - 1, 1)) if len(states) > 1 else np.zeros(len(time), int)
    nearest = np.where((after > 0) & (np.abs(states[after - 1] - time) < np.abs(states[after] - time)), after - 1, after)
    return compose(arrays["p_WB"][nearest, carrier], arrays["q_WB"][nearest, carrier], p_BS, q_BS)
