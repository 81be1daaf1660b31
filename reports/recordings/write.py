"""Writing the recordings of a run folder, each whole or not at all.

The text beside the pictures: the question, every trial's outcome, and settings and measurements of those shown.

A recording of a moment: the stretch about it alone, so that a viewer opens there, plays it slowly and in a loop.
"""

import json
import os
import tempfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
from plumbline.harness.store.disk import put_in_place
from plumbline.harness.store.journal import refuse_links
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store
from plumbline.reports.recordings.blueprint import layout
from plumbline.reports.recordings.bodies import arrow_scale, log_contacts, log_moving, log_paths, log_stage, log_truth, sharing
from plumbline.reports.recordings.camera import Framing, framing
from plumbline.reports.recordings.layout import LOG, WORLD, Floats, application_id, file_name, rgba
from plumbline.reports.recordings.metrics import curves, log_curves, ranked
from plumbline.reports.recordings.runs import RecordedRun, Stage, at_instants, shown, stage_of, touching
from plumbline.reports.recordings.sensors import log_sensors, sensed
from plumbline.reports.recordings.shapes import OVERLAID, Paint, ShapeBatch
from plumbline.reports.words.text import amount, settings_text, slug, visible

if TYPE_CHECKING:
    import rerun as rr


def write_recordings(folder: Path, cases: Collection[str] | None = None) -> tuple[Path, ...]:
    """Write `folder/recordings/<case>.rrd` for every case that has a trial, or these alone, and give their paths back.

    Raises:
        StoreError: no run folder. OSError: a recording cannot be written.
    """
    import rerun as rr

    store = Store(folder)
    refuse_links(store.folder)
    target = store.folder / "recordings"
    target.mkdir(parents=True, exist_ok=True)
    was_strict = rr.strict_mode()
    rr.set_strict_mode(True)
    try:
        there = [name for name in dict.fromkeys(store.trials["case"]) if cases is None or name in cases]
        return tuple(write_case(store, name, target) for name in there)
    finally:
        rr.set_strict_mode(was_strict)


def write_case(store: Store, name: str, target: Path) -> Path:
    """Write the recording of a case."""
    return write_stage(store, stage_of(store, name), target)


def write_stage(store: Store, stage: Stage, target: Path, mark: str = "") -> Path:
    """Write one recording under a draft's name, then give it its own. Args: mark: tells it from others of the same case."""
    import rerun as rr

    name = stage.name
    path = target / file_name(name)
    draft = target / f".{path.name}.{os.getpid()}"
    identity = digest([[t["trial"], t["status"], str(t["trajectory_hash"])] for t in stage.trials])
    rec = rr.RecordingStream(application_id(name), recording_id=f"{slug(name)}-{identity}{mark}", send_properties=False)
    rec.set_log_time_enabled(False)
    rec.set_log_tick_enabled(False)
    try:
        try:
            fill(rec, draft, store, stage)
        finally:
            rec.disconnect()  # writes the footer: the file is whole only now
        put_in_place(draft, path)
    finally:
        draft.unlink(missing_ok=True)
    return path


def fill(rec: "rr.RecordingStream", draft: Path, store: Store, stage: Stage) -> None:
    """Log all of a stage into a file."""
    import rerun as rr

    frame = framing(stage)
    arrow = frame.size / 4
    scale = arrow_scale(stage.runs, arrow)
    plotted = curves(stage)
    scanned = any(sensor["type"] != "imu" for sensor in stage.scene.get("sensors", []))
    sensors = sensed(stage)
    rec.save(draft, default_blueprint=layout(stage, frame, ranked(plotted), sensors))
    rec.send_recording_name(stage.case.get("title") or stage.name)
    rec.log(
        LOG,
        rr.TextDocument(text(store, stage, 1 / scale if scale else 0.0, sensors.notes), media_type="text/markdown"),
        static=True,
    )
    rec.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    # A scan is seen from outside, through what it hit; a wall, through itself.
    fill_mode = "MajorWireframe" if scanned else OVERLAID
    log_stage(rec, stage.scene, frame.centre, 3 * frame.radius, fill_mode)
    log_truth(rec, stage, frame.radius)
    moving = sharing(stage.bodies, [int(index) for index in stage.moving])
    for run in stage.runs:
        log_run(rec, stage, run, moving, frame, scale)
    log_curves(rec, plotted)
    log_sensors(rec, stage, frame.size / 8)
    rec.flush()


def log_run(
    rec: "rr.RecordingStream", stage: Stage, run: RecordedRun, moving: Sequence[ShapeBatch], frame: Framing, scale: float
) -> None:
    """Log the bodies of a run, their ways and their contacts, at the instants that are shown; arrows with scale [m/N]."""
    root, colour = f"{WORLD}/{run.path}", rgba(run.colour)
    log_paths(rec, f"{root}/paths", run.arrays["p_WB"][:, stage.moving], colour, frame.size)
    seen = replace(run, arrays=at_instants(run.arrays, shown(run.time, stage.length)))
    paint = Paint(colour, 3 * frame.radius, OVERLAID if touching(stage) else None)
    log_moving(rec, root, moving, seen.arrays, paint)
    log_contacts(rec, seen, scale, frame.size / 4)


ESCAPED = str.maketrans({"\n": " ", "\t": " "} | {mark: f"\\{mark}" for mark in "\\|`*_<>[]"})
"""What would end a cell, or be taken for a mark of Markdown."""


def cell(value: Any) -> str:
    """Text that stays within its cell of a Markdown table."""
    return visible(str(value)).translate(ESCAPED)


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    """Lines of a Markdown table."""
    lines = [head, ["---"] * len(head), *([cell(value) for value in row] for row in rows)]
    return [f"| {' | '.join(line)} |" for line in lines] + [""]


def outcome(trial: Mapping[str, Any], note: str) -> str:
    """The reason, and what of the trajectory is not shown."""
    return f"{trial['reason']}; {note}" if note else str(trial["reason"])


def text(store: Store, stage: Stage, newtons: float, notes: Sequence[str] = ()) -> str:
    """The whole text as Markdown.

    Args:
        newtons: the force [N] of an arrow of unit length in m, 0 where no contact is drawn. notes: what else is to be said.
    """
    case = stage.case
    lines = [f"# {cell(case.get('title') or stage.name)}", ""]
    lines += [cell(case["question"]), ""] if case.get("question") else []
    lines += [f"Truth: {cell(case['truth'])}. Source: {cell(case.get('source', ''))}", ""] if case.get("truth") else []
    if newtons:
        lines += [f"Contact forces: 1 m of arrow is {amount(newtons)} N; arrows end at three times the typical largest.", ""]
    lines += [line for note in notes for line in (cell(note), "")]
    if not stage.runs:
        lines += ["No trial of this case left a trajectory; nothing can be drawn.", ""]
    shown = {run.trial["trial"] for run in stage.runs}
    ranked = sorted(stage.trials, key=lambda t: (t["trial"] not in shown, t["engine"], t["track"], -t["dt"]))
    lines += ["## Outcomes", ""]
    lines += table(
        ("engine", "track", "time step", "shown", "status", "reason"),
        [
            (
                t["engine"],
                t["track"],
                step_in_words(t["dt"], substeps_of(str(t["resolved"]))),
                "yes" if t["trial"] in shown else "no",
                t["status"],
                outcome(t, stage.notes.get(t["trial"], "")),
            )
            for t in ranked
        ],
    )
    for run in stage.runs:
        lines += run_text(store, run.trial)
    return "\n".join(lines)


def run_text(store: Store, trial: Mapping[str, Any]) -> list[str]:
    """Trial, settings and measurements of a run that is shown."""
    lines = [f"## {cell(trial['engine'])}, {cell(trial['track'])}: {trial['status']}", ""]
    lines += [f"Trial {trial['trial']}, version {cell(trial['engine_version'])}, seed {trial['seed']}", ""]
    lines += [f"Requested: {cell(settings_text(trial['settings']))}", ""]
    lines += [f"Resolved: {cell(settings_text(trial['resolved']))}", ""]
    parameters = settings_text(trial["parameters"])
    lines += [f"Parameters: {cell(parameters)}", ""] if parameters else []
    warnings = json.loads(trial["warnings"]) if isinstance(trial["warnings"], str) else []
    lines += [f"Warning: {cell(warning)}\n" for warning in warnings]
    rows = store.measured.get(trial["trial"], ())
    verdicts = {True: "holds", False: "fails"}
    return lines + table(
        ("metric", "value", "unit", "bound", ""),
        [
            (r["metric"], amount(r["value"]), r["unit"], amount(r["at_most"]), verdicts.get(r["passed"], "observed"))
            for r in rows
        ],
    )


SHARE = 0.06
"""How far the stretch reaches to each side of the moment, of the whole time."""


@lru_cache(maxsize=8)
def moment_recording(store: Store, recording: str, at: float) -> bytes | None:
    """The bytes of a recording of the stretch about a moment [s], of the case of a recording's name; None: there is none."""
    name = next((str(case) for case in store.trials["case"].unique() if file_name(str(case)) == recording), None)
    stage = None if name is None else about(stage_of(store, name), at)
    if stage is None or not stage.runs:
        return None
    with tempfile.TemporaryDirectory() as folder:
        return write_stage(store, stage, Path(folder), f"-{at:g}").read_bytes()


def about(stage: Stage, at: float) -> Stage:
    """The stage within the stretch about a moment [s]; a run that has nothing there is left out."""
    end = max((float(run.time[-1]) for run in stage.runs), default=0.0)
    low, high = at - SHARE * end, at + SHARE * end
    runs = tuple(replace(run, arrays=_between(run.arrays, low, high)) for run in stage.runs)
    truth = _between(stage.truth, low, high) if stage.truth else stage.truth
    return replace(stage, runs=tuple(run for run in runs if len(run.time)), truth=truth if len(truth.get("time", ())) else {})


def _between(arrays: Mapping[str, Floats], low: float, high: float) -> dict[str, Floats]:
    """States, contacts and signals of the instants from `low` to `high` [s]; all else as it is."""
    time = arrays["time"]
    chosen = at_instants(arrays, np.flatnonzero((time >= low) & (time <= high)))
    for name in [name for name in arrays if name.startswith("stream:")]:
        stamps = arrays[name.rsplit("/", 1)[0] + "/time"]
        if len(arrays[name]) == len(stamps):
            chosen[name] = arrays[name][(stamps >= low) & (stamps <= high)]
    return chosen
