"""Which instants a recording shows: as many as a viewer has frames for while it plays the case.

A case plays over `WATCH`, at `FRAMES` a second. What a trajectory holds between two frames is never seen; the stretch about a
moment plays over as long, and so shows what the whole case leaves out.
"""

from collections.abc import Mapping

import numpy as np

from plumbline.reports.recordings.rotation import Floats
from plumbline.reports.recordings.runs import STATES

WATCH = 6.0, 20.0
"""Seconds that a case takes to play, at least and at most: a bullet is slowed down, a long wait made short."""

FRAMES = 60
"""A second, of the viewer."""


def playing_time(length: float) -> float:
    """Seconds that so much simulated time [s] takes to play."""
    return min(max(length, WATCH[0]), WATCH[1])


def stride_of(time: Floats, length: float) -> int:
    """Each how many-th instant `time` (t,) s of a run is shown, in a case of this length [s]: no fewer than frames."""
    passed = float(time[-1] - time[0]) if len(time) else 0.0
    if not (passed > 0 and length > 0):
        return 1
    instants_a_frame = (len(time) - 1) / passed * length / (FRAMES * playing_time(length))
    return max(1, int(instants_a_frame * (1 + 1e-9)))


def shown(time: Floats, length: float) -> Floats:
    """Places of the instants that are shown, the first and the last among them."""
    places = np.arange(0, len(time), stride_of(time, length))
    return places if not len(time) or places[-1] == len(time) - 1 else np.append(places, len(time) - 1)


def extremes(values: Floats, stride: int) -> Floats:
    """Places that a curve of values (k,) is drawn through, one for `stride` of them: no peak and no dip is left out.

    Of each stretch of twice that many, the smallest and the largest; the first and the last besides.
    """
    if stride == 1 or len(values) <= 2 * stride:
        return np.arange(len(values))
    whole = len(values) // (2 * stride) * 2 * stride
    blocks = values[:whole].reshape(-1, 2 * stride)
    first = np.arange(0, whole, 2 * stride)
    rest = np.arange(whole, len(values))
    ends = np.array([0, len(values) - 1])
    return np.unique(np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1), rest, ends]))


def at_instants(arrays: Mapping[str, Floats], places: Floats) -> dict[str, Floats]:
    """States and contacts of the instants at these places, in order; all else as it is."""
    time = arrays["time"]
    chosen = dict(arrays) | {name: arrays[name][places] for name in ("time", *STATES) if name in arrays}
    if "contacts_count" in arrays:
        counts = np.asarray(arrays["contacts_count"], dtype=np.int64)
        kept = np.zeros(len(time), dtype=bool)
        kept[places] = True
        rows = np.repeat(kept, counts)
        chosen |= {
            name: array[rows] for name, array in arrays.items() if name.startswith("contacts_") and len(array) == len(rows)
        }
        chosen["contacts_count"] = counts[kept]
    return chosen
