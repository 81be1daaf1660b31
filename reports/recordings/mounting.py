"""Where a sensor is at its readings: the pose of the body that carries it, composed with its own."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbline.reports.recordings.rotation import Floats, compose
from plumbline.reports.recordings.runs import Stage


def mounted(stage: Stage, sensor: Mapping[str, Any], arrays: Mapping[str, Floats], time: Floats) -> tuple[Floats, Floats]:
    """p_WS (k, 3) m and q_WS (k, 4) of a sensor at its readings, from the state nearest in time."""
    p_BS, q_BS = np.asarray(sensor["p_BS"]), np.asarray(sensor["q_BS"])
    carrier = next((k for k, body in enumerate(stage.bodies) if body["name"] == sensor["body"]), None)
    if carrier is None:
        return np.broadcast_to(p_BS, (len(time), 3)), np.broadcast_to(q_BS, (len(time), 4))
    states = arrays["time"]
    after = np.clip(np.searchsorted(states, time), 1, max(len(states) - 1, 1)) if len(states) > 1 else np.zeros(len(time), int)
    nearest = np.where((after > 0) & (np.abs(states[after - 1] - time) < np.abs(states[after] - time)), after - 1, after)
    return compose(arrays["p_WB"][nearest, carrier], arrays["q_WB"][nearest, carrier], p_BS, q_BS)
