"""What a case is about, over time: the quantity that its headline metric names, of each run and of the truth, and its band."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.store.store import Store
from plumbline.harness.trajectory.kinematics import angle_between
from plumbline.reports.recordings.bodies import told_places
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.recordings.metrics import errors, motion, truths
from plumbline.reports.recordings.runs import RecordedRun, Stage

AXES = "xyz"
WORDS = (
    (("penetration", "overlap", "gap", "residual"), "depth"),
    (("energy",), "energy"),
    (("angular_velocity", "angular_momentum"), "spin"),
    (("attitude", "angle", "flip", "period", "tipping"), "turn"),
    (("velocity", "speed", "share", "acceleration", "polar", "friction", "momentum"), "speed"),
    (("height", "bounce", "overhang", "collapse", "standing", "passage", "tunnel"), "height"),
    (("drift", "creep", "pose"), "shift"),
)
"""Which quantity a metric is about, by a word of its name; the first that fits. All others are about a place."""
BOUNDED = {
    "position_error_max": "m",
    "attitude_error_max": "rad",
    "velocity_error_max": "m/s",
    "angular_velocity_error_max": "rad/s",
}
"""Metrics whose bound holds at every instant, for every body, so that it is a band about each quantity of their unit."""

STILL = 1e-14
"""Poses [m, 1] that differ by less are the same: a scene in which nothing moves has no series."""


@dataclass(frozen=True, slots=True, eq=False)
class RunLine:
    """One run. Terms: time (t,) s and values (t,). off_time, off: its distance from the truth, or none. bound: of that.
    moment: when it first errs beyond the bound, or else most [s]; why: which of the two, in words; worst: the largest error.
    broken: does it end before its time, where it ceases to be finite?
    """

    engine: str
    track: str
    trial: str
    time: Floats
    values: Floats
    off_time: Floats
    off: Floats
    bound: float | None
    moment: float
    why: str
    worst: float | None
    broken: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class MotionPicture:
    """What a page draws of a case.

    Terms: title, unit: of the quantity. off_title, off_unit: of the distance from the truth, '' without one. truth: time (t,)
    and values (t,), empty where it is not told. band: how far from the truth the check lets it be, None where it says
    nothing of this quantity.
    """

    title: str
    unit: str
    off_title: str
    off_unit: str
    lines: tuple[RunLine, ...]
    truth: tuple[Floats, Floats]
    band: float | None


def motion_of(store: Store, stage: Stage) -> MotionPicture | None:
    """The series of a case as its page shows them; None where no run left a trajectory or nothing moves."""
    if not stage.runs or not len(stage.moving):
        return None
    if all(np.ptp(run.arrays[name][:, stage.moving], axis=0).max() < STILL for run in stage.runs for name in ("p_WB", "q_WB")):
        return None
    headline = str(stage.case.get("headline", ""))
    title, unit, measure = _quantity(stage, headline)
    off_name = "attitude_error" if unit == "rad" else "position_error"
    off_unit = "rad" if off_name == "attitude_error" else "m"
    bounds = _bounds(store, stage)
    lines = []
    for run, truth_there in zip(stage.runs, truths(stage), strict=True):
        values = measure(run.arrays)
        apart = errors(stage, run, truth_there).get(off_name, (np.zeros(0), np.zeros(0)))
        bound = bounds.get((run.trial["trial"], f"{off_name}_max"))
        lines.append(_line(run, values, apart, bound))
    told = set(told_places(stage)) == {int(k) for k in stage.moving} and measure is not _depth and _tells(stage, unit)
    truth = (stage.truth["time"], measure(stage.truth)) if told else (np.zeros(0), np.zeros(0))
    if not np.isfinite(truth[1]).all():
        truth = (np.zeros(0), np.zeros(0))
    band = bounds.get((stage.runs[0].trial["trial"], next((n for n, u in BOUNDED.items() if u == unit), "")))
    off = {"m": "Distance from the truth, farthest body", "rad": "Angle from the truth, largest"}[off_unit]
    has_off = any(len(line.off) for line in lines)
    return MotionPicture(
        title, unit, off if has_off else "", off_unit if has_off else "", tuple(lines), truth, band if len(truth[0]) else None
    )


def _tells(stage: Stage, unit: str) -> bool:
    """Does the truth hold what a quantity of this unit is made of?"""
    return unit in ("m", "rad") or all(name in stage.truth for name in ("v_WB", "w_WB"))


def _line(run: RecordedRun, values: Floats, apart: tuple[Floats, Floats], bound: float | None) -> RunLine:
    time, off = apart
    moment, why, worst = float(run.time[-1]), "at its end", None
    if run.note:
        why = "where it ceases to be finite"
    elif len(off):
        beyond: Floats = np.flatnonzero(off > bound) if bound is not None else np.zeros(0, dtype=np.int64)
        place, why = (int(beyond[0]), "first beyond the bound") if len(beyond) else (int(off.argmax()), "farthest off")
        moment = float(time[place])
    if len(off):
        worst = float(off.max())
    return RunLine(
        run.engine, run.track, str(run.trial["trial"]), run.time, values, time, off, bound, moment, why, worst, bool(run.note)
    )


def _bounds(store: Store, stage: Stage) -> dict[tuple[str, str], float]:
    """Bounds of the checks by trial and metric, as they were judged by."""
    table = store.measurements
    if "at_most" not in table:
        return {}
    rows = table[table["trial"].isin([run.trial["trial"] for run in stage.runs]) & table["metric"].isin(list(BOUNDED))]
    return {
        (str(trial), str(metric)): float(bound)
        for trial, metric, bound in zip(rows["trial"], rows["metric"], rows["at_most"], strict=True)
        if bound is not None and math.isfinite(bound)
    }


def _quantity(stage: Stage, headline: str) -> tuple[str, str, Callable[[Mapping[str, Floats]], Floats]]:
    """The title, the unit and the measure (arrays to (t,)) of what a metric is about."""
    kind = next((kind for words, kind in WORDS if any(word in headline for word in words)), "place")
    first = stage.truth if set(told_places(stage)) == {int(k) for k in stage.moving} else stage.runs[0].arrays
    places = np.array([int(k) for k in stage.moving])
    names = [str(stage.bodies[k]["name"]).replace("_", " ") for k in places]
    p, q = first["p_WB"][:, places], first["q_WB"][:, places]
    if kind == "depth" and all("contacts_gap" in run.arrays for run in stage.runs):
        return "Deepest penetration", "m", _depth
    if kind == "energy":
        return "Kinetic and gravitational energy", "J", lambda arrays: _energy(stage, arrays)
    if kind == "spin":
        return f"Angular speed of {_quickest(first, places, names)}", "rad/s", _spin(places[_fastest(first, places)])
    turned = angle_between(q, np.broadcast_to(q[:1], q.shape))
    if kind == "turn" and turned.max() > 1e-6:
        k = int(turned.max(axis=0).argmax())
        return f"Angle that {names[k]} has turned", "rad", lambda arrays: _turn(arrays, places[k])
    if kind == "speed":
        return "Speed of the fastest body", "m/s", lambda arrays: np.linalg.norm(arrays["v_WB"][:, places], axis=2).max(axis=1)
    ways = np.linalg.norm(p - p[:1], axis=2).max(axis=0)
    if kind == "shift":
        k = int(ways.argmax())
        return f"Distance of {names[k]} from its start", "m", lambda arrays: _shift(arrays, places[k])
    k = int(p[0, :, 2].argmax()) if kind == "height" else int(ways.argmax())
    axis = 2 if kind == "height" else int(np.ptp(p[:, k], axis=0).argmax())
    title = f"Height of {names[k]}" if axis == 2 else f"Place of {names[k]} along {AXES[axis]}"
    return title, "m", lambda arrays: arrays["p_WB"][:, places[k], axis]


def _fastest(arrays: Mapping[str, Floats], places: Floats) -> int:
    return int(np.linalg.norm(arrays["w_WB"][:, places], axis=2).max(axis=0).argmax()) if "w_WB" in arrays else 0


def _quickest(arrays: Mapping[str, Floats], places: Floats, names: Sequence[str]) -> str:
    return names[_fastest(arrays, places)]


def _spin(place: Any) -> Callable[[Mapping[str, Floats]], Floats]:
    return lambda arrays: np.linalg.norm(arrays["w_WB"][:, place], axis=1)


def _turn(arrays: Mapping[str, Floats], place: Any) -> Floats:
    q = arrays["q_WB"][:, place]
    return angle_between(q, np.broadcast_to(q[:1], q.shape))


def _shift(arrays: Mapping[str, Floats], place: Any) -> Floats:
    return np.asarray(np.linalg.norm(arrays["p_WB"][:, place] - arrays["p_WB"][:1, place], axis=1))


def _depth(arrays: Mapping[str, Floats]) -> Floats:
    """How deep the deepest contact lies at each instant (t,) m, 0 where nothing overlaps."""
    counts = np.asarray(arrays["contacts_count"], dtype=np.int64)
    deepest = np.zeros(len(counts))
    np.maximum.at(deepest, np.repeat(np.arange(len(counts)), counts), -np.asarray(arrays["contacts_gap"]))
    return deepest


def _energy(stage: Stage, arrays: Mapping[str, Floats]) -> Floats:
    kinetic = motion(stage, arrays).get("kinetic_energy", np.zeros(len(arrays["time"])))
    if "gravity" not in stage.scene.get("effects", ["gravity"]):
        return kinetic
    dynamic = [k for k, body in enumerate(stage.bodies) if body["motion"] == "dynamic"]
    mass = np.array([stage.bodies[k]["mass"] for k in dynamic])
    gravity = np.asarray(stage.scene.get("gravity", (0.0, 0.0, 0.0)), dtype=np.float64)
    energy: Floats = kinetic - (arrays["p_WB"][:, dynamic] @ gravity) @ mass
    return energy
