"""Readings against an engine's own motion: ideal signals beside what the recorded states say that a sensor has to tell.

The trajectory carries both (`harness.trial.readings_due`): '<sensor>/gyroscope_due' and '<sensor>/range_due' beside the
readings, NaN where no state was recorded at a reading's instant.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory

OTHER_SURFACE = 0.1
"""Of a range: what is farther off has met another surface, at an edge, and is no error of the range."""


def _pairs(scene: Scene, actual: Trajectory, channel: str) -> list[tuple[Floats, Floats]]:
    """The readings of a channel and what was due, of every sensor that has both. Raises: NotMeasurable."""
    pairs = []
    for sensor in scene.sensors:
        due, reading = (actual.streams.get(f"{sensor.name}/{channel}_{word}") for word in ("due", "ideal"))
        if due is not None and reading is not None:
            known = ~np.isnan(due).reshape(len(due), -1).all(axis=1)
            pairs.append((reading[known], due[known]))
    if not pairs:
        raise NotMeasurable(f"nothing is known of what a {channel} has to read")
    return pairs


@metric("rad/s")
def gyroscope_off_motion(run: Run) -> Floats:
    """definition: |ideal reading - angular velocity of the recorded state in the sensor's frame|"""
    return np.concatenate(
        [np.linalg.norm(reading - due, axis=1) for reading, due in _pairs(run.scene, run.actual, "gyroscope")]
    )


@metric("m")
def range_off_geometry(run: Run) -> Floats:
    """closed-form intersection of rays and shapes at the recorded state, of beams that meet the same surface"""
    off = []
    for reading, due in _pairs(run.scene, run.actual, "range"):
        both = np.isfinite(due) & ~np.isinf(reading)
        with np.errstate(invalid="ignore"):
            same = both & ~(np.abs(reading - due) > OTHER_SURFACE * due)
        off.append(np.abs(reading[same] - due[same]))
    errors = np.concatenate(off)
    if len(errors) == 0:
        raise NotMeasurable("no beam meets the surface that it has to meet")
    return errors
