"""The truth of a case: where it is told at given instants, and its ghost among the engines."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from plumbline.reports.recordings.bodies import log_moving, log_paths, sharing
from plumbline.reports.recordings.colour import GHOST
from plumbline.reports.recordings.layout import TRUTH, WORLD
from plumbline.reports.recordings.rotation import Floats
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.recordings.sampling import at_instants, shown
from plumbline.reports.recordings.shapes import OVERLAID, Paint

if TYPE_CHECKING:
    import rerun as rr


def truth_at(truth: Mapping[str, Floats], time: Floats) -> tuple[Floats, Floats, Floats]:
    """Places of the instants within the truth's range, and p_WB, q_WB there; between its instants by linear interpolation."""
    none = np.zeros(0, dtype=np.int64), np.zeros((0, 0, 3)), np.zeros((0, 0, 4))
    if "p_WB" not in truth or not len(time):
        return none
    known, p_WB, q_WB = truth["time"], truth["p_WB"], truth["q_WB"]
    slack = 1e-9 * max(1.0, float(known[-1]))
    kept = np.flatnonzero((time >= known[0] - slack) & (time <= known[-1] + slack))
    if len(known) < 2:
        return kept, p_WB[np.zeros(len(kept), dtype=np.int64)], q_WB[np.zeros(len(kept), dtype=np.int64)]
    after = np.clip(np.searchsorted(known, time[kept] - slack), 1, len(known) - 1)
    share = np.clip((time[kept] - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)
    share = np.where(share > 1 - 1e-6, 1.0, np.where(share < 1e-6, 0.0, share))[:, None, None]
    exact = (share == 0.0) | (share == 1.0)
    p = np.where(share == 1.0, p_WB[after], p_WB[after - 1])
    q = np.where(share == 1.0, q_WB[after], q_WB[after - 1])
    # Only where needed: a truth that is not told (NaN) at one end would spoil the other.
    p = np.where(exact, p, (1 - share) * p_WB[after - 1] + share * p_WB[after])
    near = np.where(np.sum(q_WB[after] * q_WB[after - 1], axis=-1, keepdims=True) < 0, -1.0, 1.0) * q_WB[after]
    mixed = (1 - share) * q_WB[after - 1] + share * near
    length = np.linalg.norm(mixed, axis=-1, keepdims=True)
    return kept, p, np.where(exact, q, mixed / np.where(length > 0, length, 1.0))


def told_places(stage: Stage) -> list[int]:
    """The moving bodies whose pose the truth tells at all times."""
    if "p_WB" not in stage.truth:
        return []
    poses = np.concatenate([stage.truth["p_WB"], stage.truth["q_WB"]], axis=2)
    finite = np.asarray(np.isfinite(poses).all(axis=(0, 2)))
    return [int(index) for index in stage.moving if finite[index]]


def log_truth(rec: "rr.RecordingStream", stage: Stage, extent: float) -> None:
    """Log the ghost of the truth, below world/truth."""
    places = told_places(stage)
    if not places:
        return
    seen = at_instants(stage.truth, shown(stage.truth["time"], stage.length))
    root = f"{WORLD}/{TRUTH}"
    paint = Paint(GHOST, extent, OVERLAID)
    log_moving(rec, root, sharing(stage.bodies, places), seen, paint)
    log_paths(rec, f"{root}/paths", stage.truth["p_WB"][:, places], (*GHOST[:3], 160), extent)
