"""Names in a recording: files, timelines and the paths under which everything is logged."""

from pathlib import Path

from plumbline.harness.store.journal import NoRun
from plumbline.harness.store.store import Store
from plumbline.reports.words.text import slug

SIM_TIME = "sim_time"
"""The timeline: simulated seconds, to the nanosecond. A step's number is its time over the time step, which the text tells; a
second timeline for it would take 4 bytes of each row."""

WORLD, METRICS, SENSORS, LOG = "world", "metrics", "sensors", "log"
STAGE = f"{WORLD}/scene"
"""What never moves, logged once for all engines."""

TRUTH = "truth"


def part(name: str) -> str:
    """One part of a path, from any name."""
    return slug(name)


def run_path(engine: str, track: str) -> str:
    """The part of a path that names a run: engine/track."""
    return f"{part(engine)}/{part(track)}"


def file_name(case: str) -> str:
    """The name of a case's recording within the folder 'recordings'."""
    return f"{slug(case)}.rrd"


def application_id(case: str) -> str:
    """One application per case, so that the viewer keeps a layout for each: letters, digits, - and _ only."""
    return f"plumbline-{slug(case)}"


def recording_of(folder: Path, case: str) -> Path:
    """The recording of a case in a run folder.

    Raises:
        NoRun: no run folder, or no recording of that case; the message names those that exist.
    """
    recordings = Store(folder).folder / "recordings"
    path = recordings / file_name(case)
    if path.is_file():
        return path
    there = sorted(recording.stem for recording in recordings.glob("*.rrd")) if recordings.is_dir() else []
    listed = f"there are: {', '.join(there)}" if there else "the folder has none; run the study again with recordings = true"
    raise NoRun(f"{path}: no recording of case '{case}'; {listed}")
