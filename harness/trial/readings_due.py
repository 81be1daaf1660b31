"""What ideal sensors have to read on a motion that was recorded: where no truth is known of the motion, one is known of those.

A gyroscope reads its body's angular velocity in its own frame; a beam is as long as the way to the first shape that it meets,
in closed form. Both are told at the readings' instants that were recorded too, the start left out.
"""

from collections.abc import Iterator

import numpy as np

from harness.scene import Imu, Lidar, Scene, Sensor
from harness.sensors.lidar import ideal, in_world
from harness.sensors.rays import first_hits
from harness.sensors.reader import row_of
from harness.trajectory import Floats, State, Trajectory
from harness.trajectory.kinematics import rotate_back

__all__ = ["readings_due"]

SAME = 1e-9
"""Seconds between a reading and a sample of one instant."""


def readings_due(scene: Scene, actual: Trajectory) -> dict[str, Floats]:
    """Streams '<sensor>/due' (k,), the places of the readings that are told of, and '<sensor>/gyroscope_due' (k, 3) rad/s or
    '<sensor>/range_due' (k, channels, columns) m; none of a sensor with a latency, that spins, or meets shapes without a
    closed form."""
    found: dict[str, Floats] = {}
    for sensor in scene.sensors:
        if isinstance(sensor, Imu) and sensor.latency == 0:
            told = [(k, _turning(scene, sensor, state)) for k, state in _instants(sensor, actual)]
            found |= _streams(sensor.name, "gyroscope_due", told)
        elif isinstance(sensor, Lidar) and not sensor.spinning:
            try:
                told = [(k, _ranges(scene, sensor, state)) for k, state in _instants(sensor, actual)]
            except TypeError:
                continue
            found |= _streams(sensor.name, "range_due", told)
    return found


def _streams(name: str, channel: str, told: list[tuple[int, Floats]]) -> dict[str, Floats]:
    if not told:
        return {}
    places, values = zip(*told, strict=True)
    return {f"{name}/due": np.array(places, dtype=np.float64), f"{name}/{channel}": np.array(values)}


def _instants(sensor: Sensor, actual: Trajectory) -> Iterator[tuple[int, State]]:
    """The places of readings that have a state, with it."""
    stamps = actual.streams.get(f"{sensor.name}/time", np.zeros(0))
    for k, place in enumerate(np.searchsorted(actual.time, stamps - SAME)):
        if stamps[k] > 0 and place < len(actual) and abs(actual.time[place] - stamps[k]) <= SAME:
            yield k, actual.state(int(place))


def _turning(scene: Scene, sensor: Imu, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    return rotate_back(np.array(sensor.q_BS), rotate_back(row[3:7], row[10:13]))


def _ranges(scene: Scene, sensor: Lidar, state: State) -> Floats:
    row = row_of(scene, sensor.body, state)
    origins, directions = in_world(sensor, row[:3], row[3:7])
    return ideal(sensor, scene, directions, first_hits(scene, state, origins, directions, sensor.max_range))[0]
