"""Contact forces as arrows at their points, of one scale for all engines of a case."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from plumbline.reports.recordings.colour import rgba
from plumbline.reports.recordings.layout import WORLD
from plumbline.reports.recordings.runs import RecordedRun
from plumbline.reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

LONGEST = 3.0
"""No arrow is drawn longer than this many times the typical largest one; an impact would cover the view."""


def arrow_scale(runs: Sequence[RecordedRun], length: float) -> float:
    """Metres per newton: the median run's 99th percentile of force is drawn `length` [m] long; 0 where no force is."""
    large = []
    for run in runs:
        forces = np.linalg.norm(run.arrays.get("contacts_force_W", np.zeros((0, 3))), axis=1)
        forces = forces[np.isfinite(forces) & (forces > 0)]
        if len(forces):
            large.append(float(np.percentile(forces, 99)))
    return length / float(np.median(large)) if large else 0.0


def log_contacts(rec: "rr.RecordingStream", run: RecordedRun, scale: float, length: float) -> None:
    """Log an arrow for each contact with a force, scale [m/N], with an empty row where there is none."""
    import rerun as rr

    if scale == 0.0 or "contacts_count" not in run.arrays:
        return
    counts = run.arrays["contacts_count"]
    force, point = run.arrays["contacts_force_W"], run.arrays["contacts_point_W"]
    arrows = force * scale
    lengths = np.linalg.norm(arrows, axis=1)
    kept = np.isfinite(lengths) & np.isfinite(point).all(axis=1) & (lengths > 1e-3 * length)
    row = np.repeat(np.arange(len(counts)), counts)
    shown = np.bincount(row[kept], minlength=len(counts))
    shrink = np.minimum(1.0, LONGEST * length / np.where(kept, lengths, 1.0))
    arrows = arrows * np.where(kept, shrink, 0.0)[:, None]
    path = f"{WORLD}/{run.path}/contacts"
    checked(path, run.time, arrows[kept], point[kept])
    rec.log(path, rr.Arrows3D.from_fields(colors=[rgba(run.colour)], radii=[length / 40]), static=True)
    batch = rr.Arrows3D.columns(vectors=arrows[kept].astype(np.float32), origins=point[kept].astype(np.float32))
    rec.send_columns(path, columns(run.time), batch.partition(shown))
