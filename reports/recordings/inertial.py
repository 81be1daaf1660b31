"""Inertial sensors: each channel as a plot of its three axes, the truth beside the engines."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbline.reports.recordings.layout import SENSORS, part
from plumbline.reports.recordings.sampling import extremes, stride_of
from plumbline.reports.recordings.source import Source
from plumbline.reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

CHANNELS = {"accelerometer": "m/s\u00b2", "gyroscope": "rad/s"}
"""Channels of an inertial sensor and their units."""

AXES = "xyz"


def log_inertial(rec: "rr.RecordingStream", sensor: Mapping[str, Any], source: Source, length: float) -> None:
    """Log x, y and z of each channel: the engine's signal, or the ideal one of the truth.

    As other curves, they keep every peak and dip between two frames of the viewer, of a case of this length [s].
    """
    import rerun as rr

    for channel in CHANNELS:
        signal = source.signal(sensor["name"], channel)
        if signal is None:
            continue
        time = source.stamps(sensor["name"])
        known = np.flatnonzero(np.isfinite(signal).all(axis=1) & np.isfinite(time))
        stride = stride_of(time[known], length)
        kept = known[np.unique(np.concatenate([extremes(axis, stride) for axis in signal[known].T]))]
        where = f"{SENSORS}/{part(sensor['name'])}/{channel}/{source.path}"
        checked(where, time[kept])
        names, width = [f"{source.name} {axis}" for axis in AXES], 2.0 if source.truth else 1.0
        rec.log(where, rr.SeriesLines(colors=[source.colour] * 3, names=names, widths=[width] * 3), static=True)
        values = rr.Scalars.columns(scalars=signal[kept].reshape(-1)).partition(np.full(len(kept), 3))
        rec.send_columns(where, columns(time[kept]), values)
