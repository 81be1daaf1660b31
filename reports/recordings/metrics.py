"""Speed, kinetic energy and distance from the truth over time, as plots."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from reports.recordings.colour import Rgba, rgba
from reports.recordings.layout import METRICS, TRUTH
from reports.recordings.rotation import Floats, angle
from reports.recordings.runs import Run, Stage
from reports.recordings.timeline import checked, columns
from reports.recordings.truth import truth_at

if TYPE_CHECKING:
    import rerun as rr

__all__ = ["TITLES", "log_metrics"]

TITLES = {
    "position_error": "Distance from the truth, farthest body [m]",
    "attitude_error": "Angle from the truth, largest [rad]",
    "speed": "Speed, fastest body [m/s]",
    "kinetic_energy": "Kinetic energy of all bodies [J]",
}
"""Metrics and what their plots are called."""


def motion(stage: Stage, arrays: Mapping[str, Floats]) -> dict[str, Floats]:
    """Largest speed |v_WB| [m/s] and sum of m v^2/2 + w I w/2 [J] of all dynamic bodies, each (t,)."""
    dynamic = np.array([k for k, body in enumerate(stage.bodies) if body["motion"] == "dynamic"], dtype=np.int64)
    if not len(dynamic):
        return {}
    mass = np.array([stage.bodies[k]["mass"] for k in dynamic])
    inertia = np.array([stage.bodies[k]["inertia"] for k in dynamic])
    v_WB, w_WB, q_WB = (arrays[name][:, dynamic] for name in ("v_WB", "w_WB", "q_WB"))
    w_BB = turned_back(q_WB, w_WB)
    translation = 0.5 * mass * np.sum(v_WB**2, axis=2)
    rotation = 0.5 * np.einsum("tni,nij,tnj->tn", w_BB, inertia, w_BB)
    return {"speed": np.linalg.norm(v_WB, axis=2).max(axis=1), "kinetic_energy": (translation + rotation).sum(axis=1)}


def turned_back(q: Floats, v_W: Floats) -> Floats:
    """Vectors given in W, in the body frames."""
    from reports.recordings.rotation import rotate

    return rotate(q * np.array([1.0, -1.0, -1.0, -1.0]), v_W)


def errors(stage: Stage, run: Run) -> dict[str, tuple[Floats, Floats]]:
    """Instants and largest distance [m] and angle [rad] from the truth over all moving bodies, where the truth is told."""
    found: dict[str, tuple[Floats, Floats]] = {}
    places = stage.moving
    kept, p_WB, q_WB = truth_at(stage.truth, run.time)
    if not len(kept) or not len(places):
        return {}
    for name, apart in (
        ("position_error", np.linalg.norm(run.arrays["p_WB"][kept][:, places] - p_WB[:, places], axis=2)),
        ("attitude_error", angle(run.arrays["q_WB"][kept][:, places], q_WB[:, places])),
    ):
        told = np.isfinite(apart)
        rows = told.any(axis=1)
        if rows.any():
            found[name] = run.time[kept][rows], np.where(told, apart, -np.inf)[rows].max(axis=1)
    return found


def log_metrics(rec: "rr.RecordingStream", stage: Stage) -> set[str]:
    """Log all plots; returns the metrics that have a line."""
    logged: set[str] = set()
    for run in stage.runs:
        name, width = f"{run.engine} {run.track}", 2.0 if run.track == "tuned" else 1.0
        curves = {metric: (run.time, values) for metric, values in motion(stage, run.arrays).items()} | errors(stage, run)
        for metric, (time, values) in curves.items():
            finite = np.isfinite(values)
            line(
                rec,
                f"{METRICS}/{metric}/{run.path}",
                time[finite],
                values[finite],
                run.steps_at(time[finite]),
                name,
                rgba(run.colour),
                width,
            )
            logged.add(metric)
    if "v_WB" in stage.truth and len(stage.moving):
        time = stage.truth["time"]
        for metric, values in motion(stage, stage.truth).items():
            finite = np.isfinite(values)
            steps = np.rint(time / stage.dt) if stage.dt > 0 else np.arange(len(time))
            line(
                rec,
                f"{METRICS}/{metric}/{TRUTH}",
                time[finite],
                values[finite],
                steps[finite],
                "truth",
                (170, 170, 180, 255),
                3.0,
            )
    return logged


def line(
    rec: "rr.RecordingStream", path: str, time: Floats, values: Floats, steps: Floats, name: str, colour: Rgba, width: float
) -> None:
    """Log one curve with its name and look."""
    import rerun as rr

    if not len(time):
        return
    checked(path, time, values)
    rec.log(path, rr.SeriesLines(colors=[colour], names=[name], widths=[width]), static=True)
    rec.send_columns(path, columns(time, steps), rr.Scalars.columns(scalars=values))
