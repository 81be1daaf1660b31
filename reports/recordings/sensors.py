"""Sensor signals: inertial channels as plots, scans as point clouds in the world."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.recordings.colour import GHOST, Rgba, rgba
from reports.recordings.layout import SENSORS, TRUTH, part
from reports.recordings.rotation import Floats, compose, rotate
from reports.recordings.runs import Run, Stage
from reports.recordings.timeline import checked, columns

if TYPE_CHECKING:
    import rerun as rr

__all__ = ["CHANNELS", "log_sensors", "sensor_paths"]

CHANNELS = {"accelerometer": "m/s\u00b2", "gyroscope": "rad/s"}
"""Channels of an inertial sensor and their units."""

AXES = "xyz"


def sensor_paths(stage: Stage) -> tuple[list[str], list[str]]:
    """The paths of inertial channels and of clouds that a stage has signals for, without engine and track."""
    channels: list[str] = []
    clouds: list[str] = []
    for sensor in stage.scene.get("sensors", []):
        root, prefix = f"{SENSORS}/{part(sensor['name'])}", f"stream:{sensor['name']}"
        if sensor["type"] == "imu":
            channels += [f"{root}/{c}" for c in CHANNELS if any(f"{prefix}/{c}" in run.arrays for run in stage.runs)]
        elif any(f"{prefix}/range" in run.arrays for run in stage.runs):
            clouds.append(f"{root}/points")
    return channels, clouds


def log_sensors(rec: "rr.RecordingStream", stage: Stage) -> None:
    """Log the signals of all sensors of a scene."""
    for sensor in stage.scene.get("sensors", []):
        sources: list[tuple[str, Mapping[str, Floats], Rgba, str, Run | None]]
        sources = [(run.path, run.arrays, rgba(run.colour), f"{run.engine} {run.track}", run) for run in stage.runs]
        sources += [(TRUTH, stage.truth, (*GHOST[:3], 255), "truth", None)]
        for path, arrays, colour, name, run in sources:
            if sensor["type"] == "imu":
                log_imu(rec, stage, sensor, path, arrays, colour, name, run)
            elif sensor["type"] == "lidar":
                log_lidar(rec, stage, sensor, path, arrays, colour, run)


def log_imu(
    rec: "rr.RecordingStream",
    stage: Stage,
    sensor: Mapping[str, Any],
    path: str,
    arrays: Mapping[str, Floats],
    colour: Rgba,
    name: str,
    run: Run | None,
) -> None:
    """Log x, y and z of each channel: the engine's signal, and the ideal one of the truth."""
    import rerun as rr

    prefix = f"stream:{sensor['name']}"
    for channel in CHANNELS:
        signal = arrays.get(f"{prefix}/{channel}_ideal" if run is None else f"{prefix}/{channel}")
        if signal is None or not len(signal):
            continue
        time = arrays[f"{prefix}/time"]
        finite = np.isfinite(signal).all(axis=1) & np.isfinite(time)
        where = f"{SENSORS}/{part(sensor['name'])}/{channel}"
        checked(f"{where}/{path}", time[finite])
        rec.log(
            f"{where}/{path}",
            rr.SeriesLines(colors=[colour] * 3, names=[f"{name} {axis}" for axis in AXES], widths=[1.0 if run else 2.0] * 3),
            static=True,
        )
        values = rr.Scalars.columns(scalars=signal[finite].reshape(-1)).partition(np.full(int(finite.sum()), 3))
        rec.send_columns(f"{where}/{path}", columns(time[finite], (run or stage).steps_at(time[finite])), values)


def beams(sensor: Mapping[str, Any]) -> Floats:
    """Unit directions of a scan in S, (channels, columns, 3): elevations told or between the bounds, azimuths over 2 pi."""
    own = sensor.get("elevations")
    even = np.linspace(sensor["elevation_low"], sensor["elevation_high"], sensor["channels"])
    elevation = (even if own is None else np.array(own, dtype=np.float64))[:, None]
    azimuth = 2.0 * np.pi * np.arange(sensor["columns"])[None, :] / sensor["columns"]
    up = np.broadcast_to(np.sin(elevation), (sensor["channels"], sensor["columns"]))
    return np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), up], axis=-1)


def carrier(stage: Stage, sensor: Mapping[str, Any], arrays: Mapping[str, Floats], time: Floats) -> tuple[Floats, Floats]:
    """Pose of the sensor in W at its readings, from the state nearest in time."""
    p_BS, q_BS = np.asarray(sensor["p_BS"]), np.asarray(sensor["q_BS"])
    place = next((k for k, body in enumerate(stage.bodies) if body["name"] == sensor["body"]), None)
    if place is None:
        return np.broadcast_to(p_BS, (len(time), 3)), np.broadcast_to(q_BS, (len(time), 4))
    states = arrays["time"]
    after = np.clip(np.searchsorted(states, time), 1, max(len(states) - 1, 1)) if len(states) > 1 else np.zeros(len(time), int)
    nearest = np.where((after > 0) & (np.abs(states[after - 1] - time) < np.abs(states[after] - time)), after - 1, after)
    return compose(arrays["p_WB"][nearest, place], arrays["q_WB"][nearest, place], p_BS, q_BS)


def log_lidar(
    rec: "rr.RecordingStream",
    stage: Stage,
    sensor: Mapping[str, Any],
    path: str,
    arrays: Mapping[str, Floats],
    colour: Rgba,
    run: Run | None,
) -> None:
    """Log the points that a scan hit, in W; beams without a return leave none."""
    import rerun as rr

    prefix = f"stream:{sensor['name']}"
    ranges = arrays.get(f"{prefix}/range_ideal" if run is None else f"{prefix}/range")
    if ranges is None or not len(ranges):
        return
    time = arrays[f"{prefix}/time"]
    p_WS, q_WS = carrier(stage, sensor, arrays, time)
    directions = beams(sensor).reshape(-1, 3)
    flat = ranges.reshape(len(time), -1)
    clouds = []
    for p, q, distance in zip(p_WS, q_WS, flat, strict=True):
        hit = np.isfinite(distance)
        clouds.append(
            (p + rotate(np.broadcast_to(q, (int(hit.sum()), 4)), directions[hit] * distance[hit, None])).astype(np.float32)
        )
    where = f"{SENSORS}/{part(sensor['name'])}/points"
    points = np.concatenate(clouds)
    checked(f"{where}/{path}", time, points)
    look = rr.Points3D.from_fields(colors=[colour], radii=rr.Radius.ui_points(1.2))
    rec.log(f"{where}/{path}", look, static=True)
    rows = rr.Points3D.columns(positions=points).partition([len(cloud) for cloud in clouds])
    rec.send_columns(f"{where}/{path}", columns(time, (run or stage).steps_at(time)), rows)
