"""Names, colours and times in a recording: files, timelines, the paths under which everything is logged, and poses composed."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.store.journal import NoRun
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory.kinematics import product, rotate
from plumbline.reports.charts.marks import BACKGROUNDS
from plumbline.reports.words.text import slug

if TYPE_CHECKING:
    import rerun as rr


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


Floats: TypeAlias = NDArray[Any]


def compose(p_WB: Floats, q_WB: Floats, p_BS: Floats, q_BS: Floats) -> tuple[Floats, Floats]:
    """The pose p_WS, q_WS of a frame S that sits at p_BS, q_BS in the body frame B."""
    return p_WB + rotate(q_WB, np.broadcast_to(p_BS, p_WB.shape)), product(q_WB, q_BS)


Rgba = tuple[int, int, int, int]

GHOST: Rgba = (226, 226, 236, 90)
"""The truth: a pale shape that engines are seen through."""

GROUND: Rgba = (74, 82, 94, 255)
"""What never moves."""

GRID: Rgba = (104, 114, 128, 255)
"""Lines on a ground plane, against which motion is seen."""


FLOOR: Rgba = (140, 150, 165, 70)
"""The grid below a motion in free space."""


def rgba(colour: str, opacity: int = 255) -> Rgba:
    """'#rrggbb' as numbers."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue, opacity


BACKGROUND: Rgba = rgba(BACKGROUNDS["dark"])
"""The dark page of the report, against which the engines' colours keep their contrast."""


def checked(path: str, time: Floats, *values: Floats) -> None:
    """Refuse what a viewer would take without a word: numbers that are not finite, times out of order, lengths that differ.

    Raises:
        ValueError: naming the path.
    """
    if not (np.isfinite(time).all() and (np.diff(time) >= 0).all()):
        raise ValueError(f"{path}: times [s] must be finite and in order")
    for array in values:
        if not np.isfinite(array).all():
            raise ValueError(f"{path}: {int((~np.isfinite(array)).sum())} of {array.size} numbers are not finite")


def columns(time: Floats) -> "list[rr.TimeColumn]":
    """Simulated time [s] of each row."""
    import rerun as rr

    exact: Any = np.rint(np.asarray(time) * 1e9).astype("timedelta64[ns]")
    return [rr.TimeColumn(SIM_TIME, duration=exact)]
