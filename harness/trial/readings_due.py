"""What ideal sensors have to read on a motion that was recorded: where no truth is known of the motion, one is known of those.

A gyroscope reads its body's angular velocity in its own frame; a beam is as long as the way to the first shape that it meets,
in closed form. Both are told at the readings' instants that were recorded too, the start left out.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from plumbline.harness.scene import Imu, Lidar, Scene, Sensor
from plumbline.harness.sensors.lidar import ideal, in_world
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.reader import row_of
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import rotate_back

SAME = 1e-9
"""Seconds between a reading and a sample of one instant."""


def readings_due(scene: Scene, actual: Trajectory) -> dict[str, Floats]:
    """Streams '<sensor>/gyroscope_due' (k, 3) rad/s and '<sensor>/range_due' (k, channels, columns) m, as many as there are
    readings, NaN where a reading has no state beside it; none of a sensor with a latency, that spins, or meets shapes without
    a closed form."""
    due: dict[str, Floats] = {}
    for sensor in scene.sensors:
        try:
            if isinstance(sensor, Imu) and sensor.latency == 0:
                due |= _stream(scene, sensor, actual, "gyroscope", _turning)
            elif isinstance(sensor, Lidar) and not sensor.spinning:
                due |= _stream(scene, sensor, actual, "range", _ranges)
        except TypeError:  # of `first_hits`: a shape without a closed form
            continue
    return due


def _stream(
    scene: Scene, sensor: Any, actual: Trajectory, channel: str, law: Callable[[Scene, Any, State], Floats]
) -> dict[str, Floats]:
    read = actual.streams.get(f"{sensor.name}/{channel}_ideal")
    if read is None:
        return {}
    due = np.full(read.shape, np.nan)
    for k, state in _instants(sensor, actual):
        due[k] = law(scene, sensor, state)
    return {f"{sensor.name}/{channel}_due": due}


def _instants(sensor: Sensor, actual: Trajectory) -> Iterator[tuple[int, State]]:
    """The places of readings that have a state, with it."""
    stamps = actual.streams.get(f"{sensor.name}/time", np.zeros(0))
    for k, sample in enumerate(np.searchsorted(actual.time, stamps - SAME)):
        if stamps[k] > 0 and sample < len(actual) and abs(actual.time[sample] - stamps[k]) <= SAME:
            yield k, actual.state(int(sample))


def _turning(scene: Scene, sensor: Imu, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    return rotate_back(np.array(sensor.q_BS), rotate_back(row[3:7], row[10:13]))


def _ranges(scene: Scene, sensor: Lidar, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    origins, directions = in_world(sensor, row[:3], row[3:7])
    return ideal(sensor, scene, directions, first_hits(scene, state, origins, directions, sensor.max_range))[0]
