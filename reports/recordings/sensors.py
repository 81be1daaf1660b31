"""Sensor signals of a case: which there are, and each logged by the file of its kind."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plumbline.reports.recordings.cameras import TYPES, camera_path, log_camera, pictured, shown_frames
from plumbline.reports.recordings.inertial import CHANNELS, log_inertial
from plumbline.reports.recordings.layout import SENSORS, part
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.recordings.scans import log_scans
from plumbline.reports.recordings.source import Source, sources

if TYPE_CHECKING:
    import rerun as rr


@dataclass(frozen=True, slots=True)
class CameraView:
    """The pictures of one camera and channel: a title, and by the name of who tells it the path of the picture."""

    title: str
    paths: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Sensed:
    """What a stage has signals for.

    Terms:
        channels, clouds, cameras: paths of inertial signals, scans and cameras, without engine and track. views: pictures.
        notes: what is not shown, in words.
    """

    channels: Sequence[str] = ()
    clouds: Sequence[str] = ()
    cameras: Sequence[str] = ()
    views: Sequence[CameraView] = ()
    notes: Sequence[str] = ()


def sensed(stage: Stage) -> Sensed:
    """The signals of all sensors of a stage."""
    channels, clouds, cameras, views, notes = [], [], [], [], []
    tellers = sources(stage)
    runs = [source for source in tellers if not source.truth]
    for sensor in stage.scene.get("sensors", []):
        name, root = sensor["name"], f"{SENSORS}/{part(sensor['name'])}"
        if sensor["type"] == "imu":
            channels += [f"{root}/{c}" for c in CHANNELS if any(run.signal(name, c) is not None for run in runs)]
        elif sensor["type"] == "lidar":
            clouds += [f"{root}/points"] if any(run.signal(name, "range") is not None for run in runs) else []
        elif sensor["type"] in TYPES:
            shown = _views(sensor, tellers)
            views += shown
            cameras += [camera_path(sensor, "").rstrip("/")] if shown else []
            notes += _notes(sensor, tellers)
    return Sensed(channels, clouds, cameras, views, notes)


def _views(sensor: Mapping[str, Any], tellers: Sequence[Source]) -> list[CameraView]:
    views = []
    for channel in ("colour", "depth"):
        showing = [source for source in tellers if channel in pictured(sensor, source)]
        if showing:
            paths = {source.name: f"{camera_path(sensor, source.path)}/{channel}" for source in showing}
            views.append(CameraView(f"{sensor['name']} {channel}", paths))
    return views


def _notes(sensor: Mapping[str, Any], tellers: Sequence[Source]) -> list[str]:
    counts = [len(source.stamps(sensor["name"])) for source in tellers if pictured(sensor, source)]
    most = max(counts, default=0)
    kept = len(shown_frames(sensor, most)) if most else 0
    return [f"{sensor['name']}: {kept} of {most} pictures are shown, evenly spaced in time."] if kept < most else []


def log_sensors(rec: "rr.RecordingStream", stage: Stage, size: float) -> None:
    """Log the signals of all sensors of a scene.

    Args: size: how far from a camera its picture is drawn [m].
    """
    for sensor in stage.scene.get("sensors", []):
        for source in sources(stage):
            if sensor["type"] == "imu":
                log_inertial(rec, sensor, source, stage.length)
            elif sensor["type"] == "lidar":
                log_scans(rec, stage, sensor, source)
            elif sensor["type"] in TYPES:
                log_camera(rec, stage, sensor, source, size)
