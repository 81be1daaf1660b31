"""Speed, kinetic energy and distance from the truth over time, as plots."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plumbline.harness.trajectory.kinematics import angle_between, rotate
from plumbline.reports.recordings.bodies import truth_at
from plumbline.reports.recordings.layout import METRICS, TRUTH, Floats, Rgba, checked, columns, rgba
from plumbline.reports.recordings.runs import RecordedRun, Stage, extremes, stride_of
from plumbline.reports.words.called import WORDS

if TYPE_CHECKING:
    import rerun as rr

TITLES = WORDS["plots"]
"""Metrics and what their plots are called."""


CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])

NOTHING = 1e-5
"""Below this [in the metric's unit] a plot shows rounding, and steps behind the others."""

TOGETHER = "together"
"""The path of curves that share their instants; the names of the lines say whose they are."""

TRUTH_LINE: Rgba = (170, 170, 180, 255)


@dataclass(frozen=True, slots=True)
class Curve:
    """One line of a plot: values (k,) of a metric at times (k,) s; path, name, colour and width say whose it is."""

    metric: str
    path: str
    name: str
    colour: Rgba
    width: float
    time: Floats
    values: Floats


def motion(stage: Stage, arrays: Mapping[str, Floats]) -> dict[str, Floats]:
    """Largest speed |v_WB| [m/s] and sum of m v^2/2 + w I w/2 [J] of all dynamic bodies, each (t,)."""
    dynamic = np.array([k for k, body in enumerate(stage.bodies) if body["motion"] == "dynamic"], dtype=np.int64)
    if not len(dynamic):
        return {}
    mass = np.array([stage.bodies[k]["mass"] for k in dynamic])
    inertia = np.array([stage.bodies[k]["inertia"] for k in dynamic])
    v_WB, w_WB = arrays["v_WB"][:, dynamic], arrays["w_WB"][:, dynamic]
    squares = np.einsum("tni,tni->tn", v_WB, v_WB)
    energy = 0.5 * squares @ mass
    # A ball's inertia is the same about every axis: its attitude says nothing of its energy.
    round_ones = (inertia == inertia[:, :1, :1] * np.eye(3)).all(axis=(1, 2))
    if round_ones.any():
        w_WB_round = w_WB[:, round_ones]
        energy += 0.5 * np.einsum("tni,tni->tn", w_WB_round, w_WB_round) @ inertia[round_ones, 0, 0]
    if not round_ones.all():
        w_BB = rotate(arrays["q_WB"][:, dynamic[~round_ones]] * CONJUGATE, w_WB[:, ~round_ones])
        spun = (w_BB.transpose(1, 0, 2) @ inertia[~round_ones]).transpose(1, 0, 2)
        energy += 0.5 * np.einsum("tni,tni->t", w_BB, spun)
    return {"speed": np.sqrt(squares.max(axis=1)), "kinetic_energy": energy}


def errors(stage: Stage, run: RecordedRun, told: tuple[Floats, Floats, Floats]) -> dict[str, tuple[Floats, Floats]]:
    """Instants and largest distance [m] and angle [rad] from the truth over all moving bodies, where the truth is told.

    Args: told: the truth at the run's instants, one of `truths`.
    """
    by_metric: dict[str, tuple[Floats, Floats]] = {}
    places = stage.moving
    kept, p_WB, q_WB = told
    if not len(kept) or not len(places):
        return {}
    for name, apart in (
        ("position_error", np.linalg.norm(run.arrays["p_WB"][kept][:, places] - p_WB[:, places], axis=2)),
        ("attitude_error", angle_between(run.arrays["q_WB"][kept][:, places], q_WB[:, places])),
    ):
        known = np.isfinite(apart)
        rows = known.any(axis=1)
        if rows.any():
            by_metric[name] = run.time[kept][rows], np.where(known, apart, -np.inf)[rows].max(axis=1)
    return by_metric


def truths(stage: Stage) -> list[tuple[Floats, Floats, Floats]]:
    """The truth at the instants of each run, as `truth_at` has it; runs at the same time step share both."""
    instants = {run.time.tobytes(): run.time for run in stage.runs}
    told = {key: truth_at(stage.truth, time) for key, time in instants.items()}
    return [told[run.time.tobytes()] for run in stage.runs]


def curves(stage: Stage) -> tuple[Curve, ...]:
    """All curves of a stage, without what is not finite, as densely as the viewer has frames."""
    collected: list[Curve] = []
    for run, told in zip(stage.runs, truths(stage), strict=True):
        drawn = {metric: (run.time, values) for metric, values in motion(stage, run.arrays).items()} | errors(stage, run, told)
        for metric, (time, values) in drawn.items():
            kept = _drawn(time, values, stage.length)
            look = rgba(run.colour), 2.5 if run.track == "tuned" else 1.2
            collected.append(Curve(metric, run.path, f"{run.engine} {run.track}", *look, time[kept], values[kept]))
    if "v_WB" in stage.truth:
        for metric, values in motion(stage, stage.truth).items():
            kept = _drawn(stage.truth["time"], values, stage.length)
            time = stage.truth["time"][kept]
            collected.append(Curve(metric, TRUTH, "truth", TRUTH_LINE, 3.5, time, values[kept]))
    return tuple(curve for curve in collected if len(curve.time))


def _drawn(time: Floats, values: Floats, length: float) -> Floats:
    """Places of what is finite of a curve; of what lies between two frames its peaks and dips."""
    finite = np.flatnonzero(np.isfinite(values))
    return np.asarray(finite[extremes(values[finite], stride_of(time[finite], length))])


def ranked(drawn: Iterable[Curve]) -> list[str]:
    """The metrics that have a curve, those first in which the runs differ most visibly from nothing."""
    largest: dict[str, float] = {}
    for curve in drawn:
        largest[curve.metric] = max(largest.get(curve.metric, 0.0), float(np.abs(curve.values).max()))
    return sorted(largest, key=lambda metric: (largest[metric] < NOTHING, list(TITLES).index(metric)))


def log_curves(rec: "rr.RecordingStream", drawn: Iterable[Curve]) -> None:
    """Log all curves below metrics/<metric>/.

    Those that are drawn through the same instants share a path and rows, as engines at the same time step do; one that has
    instants of its own, as a run that ended early, stands under its engine and track.
    """
    import rerun as rr

    groups: dict[tuple[str, bytes], list[Curve]] = {}
    for curve in drawn:
        groups.setdefault((curve.metric, curve.time.tobytes()), []).append(curve)
    taken: set[str] = set()
    for (metric, _), group in groups.items():
        path = f"{METRICS}/{metric}/{group[0].path if len(group) == 1 else TOGETHER}"
        while path in taken:
            path = f"{path}_too"
        taken.add(path)
        values = np.stack([curve.values for curve in group], axis=1)
        checked(path, group[0].time, values)
        look = rr.SeriesLines(
            colors=[curve.colour for curve in group],
            names=[curve.name for curve in group],
            widths=[curve.width for curve in group],
        )
        rec.log(path, look, static=True)
        rows = rr.Scalars.columns(scalars=values.reshape(-1)).partition(np.full(len(values), len(group)))
        rec.send_columns(path, columns(group[0].time), rows)
