"""Writing the recordings of a run folder, each whole or not at all."""

import os
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from plumbline.harness.store.disk import put_in_place
from plumbline.harness.store.journal import refuse_links
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store
from plumbline.reports.recordings.blueprint import layout
from plumbline.reports.recordings.bodies import log_moving, log_paths, log_stage, sharing
from plumbline.reports.recordings.camera import Framing, framing
from plumbline.reports.recordings.colour import rgba
from plumbline.reports.recordings.contacts import arrow_scale, log_contacts
from plumbline.reports.recordings.layout import LOG, WORLD, application_id, file_name
from plumbline.reports.recordings.log import text
from plumbline.reports.recordings.metrics import curves, log_curves, ranked
from plumbline.reports.recordings.runs import RecordedRun, Stage, stage_of, touching
from plumbline.reports.recordings.sampling import at_instants, shown
from plumbline.reports.recordings.sensors import log_sensors, sensed
from plumbline.reports.recordings.shapes import OVERLAID, Paint, ShapeBatch
from plumbline.reports.recordings.truth import log_truth
from plumbline.reports.words.text import slug

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
