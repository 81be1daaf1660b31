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

__all__ = ["CHANNELS", "log_sensors"]

CHANNELS = {"accelerometer": "m/s\u00b2", "gyroscope": "rad/s"}
"""Channels of an inertial sensor and their units."""

AXES = "xyz"


def log_sensors(rec: "rr.RecordingStream", stage: Stage) -> set[str]:
    """Log the signals of all sensors of a scene; returns the paths that hold plots or clouds, without engine and track."""
    logged: set[str] = set()
    truth = {name: array for name, array in stage.truth.items()}
    for sensor in stage.scene.get("sensors", []):
        sources = [(run.path, run.arrays, rgba(run.colour), f"{run.engine} {run.track}", run) for run in stage.runs]
        sources += [(TRUTH, truth, (*GHOST[:3], 255), "truth", None)]
        for path, arrays, colour, name, run in sources:
            if sensor["type"] == "imu":
                logged |= log_imu(rec, stage, sensor, path, arrays, colour, name, run)
            elif sensor["type"] == "lidar":
                logged |= log_lidar(rec, stage, sensor, path, arrays, colour, run)
    return logged


def steps_of(stage: Stage, run: Run | None, time: Floats) -> Floats:
    """Numbers of steps at the readings."""
    if run is not None:
        return run.steps_at(time)
    return np.rint(time / stage.dt) if stage.dt > 0 else np.arange(len(time))


def log_imu(
    rec: "rr.RecordingStream",
    stage: Stage,
    sensor: Mapping[str, Any],
    path: str,
    arrays: Mapping[str, Floats],
    colour: Rgba,
    name: str,
    run: Run | None,
) -> set[str]:
    """Log x, y and z of each channel: the engine's signal, and the ideal one of the truth."""
    import rerun as rr

    logged: set[str] = set()
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
        rec.send_columns(f"{where}/{path}", columns(time[finite], steps_of(stage, run, time[finite])), values)
        logged.add(where)
    return logged


def beams(sensor: Mapping[str, Any]) -> Floats:
    """Unit directions of a scan in the sensor frame, (channels, columns, 3): elevations between the bounds, azimuths over 2 pi."""
    elevation = np.linspace(sensor["elevation_low"], sensor["elevation_high"], sensor["channels"])[:, None]
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
) -> set[str]:
    """Log the points that a scan hit, in W; beams without a return leave none."""
    import rerun as rr

    prefix = f"stream:{sensor['name']}"
    ranges = arrays.get(f"{prefix}/range_ideal" if run is None else f"{prefix}/range")
    if ranges is None or not len(ranges):
        return set()
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
    look = rr.Points3D.from_fields(colors=[colour], radii=[rr.Radius.ui_points(1.2)])
    rec.log(f"{where}/{path}", look, static=True)
    rows = rr.Points3D.columns(positions=points).partition([len(cloud) for cloud in clouds])
    rec.send_columns(f"{where}/{path}", columns(time, steps_of(stage, run, time)), rows)
    return {where}
