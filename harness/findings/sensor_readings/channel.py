"""The channels of a trial's sensors: what was read, what an ideal sensor would have read, and what the truth says it should."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.scene import Camera, DepthCamera, Lidar, Scene, Sensor
from plumbline.harness.trajectory import Floats

RAYS = "rays"
"""The type, and the stream, of a case that casts rays of its own, without a sensor."""

UNITS: Mapping[str, Mapping[str, str]] = {
    "imu": {"accelerometer": "m/s2", "gyroscope": "rad/s"},
    "lidar": {"range": "m", "intensity": "1"},
    "camera": {"colour": "1", "depth": "m", "body": "1"},
    "depth_camera": {"depth": "m", "body": "1"},
    RAYS: {"range": "m"},
}
"""Units of the channels, by type of sensor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One channel of one sensor in one trial.

    Terms:
        sensor: as in the scene, None for rays without one. name, type: of the sensor. channel, unit.
        time (k,) s. read (k, ...): what came out; ideal (k, ...): without noise, the same where there is none.
        truth (k, ...): ideal by the truth, None where it does not tell; untold: why. excused (k, ...): 1 where the truth says
        that geometry or optics take the reading away, None where it does not say. beside: the other channels by name, as
        (ideal, truth).
    """

    sensor: Sensor | None
    name: str
    type: str
    channel: str
    unit: str
    time: Floats
    read: Floats
    ideal: Floats
    truth: Floats | None
    untold: str
    excused: Floats | None
    beside: Mapping[str, tuple[Floats, Floats | None]]


def rays_of(sensor: Sensor) -> int:
    """Beams or pixels of one reading; 0 for a sensor that casts none."""
    if isinstance(sensor, Lidar):
        return sensor.channels * sensor.columns
    return sensor.width * sensor.height if isinstance(sensor, Camera | DepthCamera) else 0


def channels(scene: Scene, arrays: Mapping[str, Any]) -> Iterator[Channel]:
    """The channels that were recorded, sensor by sensor.

    Args: arrays: of a trajectory, as `harness.store.store.Store.trajectory` gives them.
    """
    known: list[tuple[Sensor | None, str, str]] = [(sensor, sensor.name, sensor.type) for sensor in scene.sensors]
    for sensor, name, kind in [*known, (None, RAYS, RAYS)]:
        every = {channel: _signals(name, channel, arrays) for channel in UNITS[kind]}
        recorded = {channel: signals for channel, signals in every.items() if signals is not None}
        for channel, (read, ideal, truth, untold) in recorded.items():
            yield Channel(
                sensor=sensor,
                name=name,
                type=kind,
                channel=channel,
                unit=UNITS[kind][channel],
                time=arrays[f"stream:{name}/time"],
                read=read,
                ideal=ideal,
                truth=truth,
                untold=untold,
                excused=_excused(name, read, arrays),
                beside={other: (signals[1], signals[2]) for other, signals in recorded.items() if other != channel},
            )


def _excused(name: str, read: Floats, arrays: Mapping[str, Any]) -> Floats | None:
    lost = arrays.get(f"truth_stream:{name}/lost")
    return None if lost is None or lost.shape != read.shape else np.asarray(lost)


def _signals(name: str, channel: str, arrays: Mapping[str, Any]) -> tuple[Floats, Floats, Floats | None, str] | None:
    plain, ideal = f"stream:{name}/{channel}", f"stream:{name}/{channel}_ideal"
    if f"stream:{name}/time" not in arrays or (plain not in arrays and ideal not in arrays):
        return None
    read = np.asarray(arrays[plain] if plain in arrays else arrays[ideal])
    without = np.asarray(arrays.get(ideal, read))
    truth = next((arrays[f"truth_{key}"] for key in (ideal, plain) if f"truth_{key}" in arrays), None)
    if truth is None:
        return read, without, None, "the truth does not tell this channel"
    here, there = arrays[f"stream:{name}/time"], arrays.get(f"truth_stream:{name}/time")
    if there is None or here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
        return read, without, None, "the truth stands at other times than the readings"
    if truth.shape != without.shape:
        return read, without, None, f"the truth has the shape {truth.shape}, the readings {without.shape}"
    return read, without, np.asarray(truth), ""
