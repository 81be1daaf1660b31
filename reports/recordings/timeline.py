"""The timeline that every column is logged on."""

from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.reports.recordings.layout import SIM_TIME
from plumbline.reports.recordings.rotation import Floats

if TYPE_CHECKING:
    import rerun as rr


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
