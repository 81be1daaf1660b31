"""A run folder of planted readings: every number in it is made from a law that is known here, nothing is measured."""

import dataclasses
import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.scene import (
    AxisNoise,
    Body,
    Camera,
    DepthCamera,
    Imu,
    ImuNoise,
    Lidar,
    LidarNoise,
    PlacedShape,
    Scene,
    Sphere,
    StereoNoise,
)
from plumbline.harness.store.arrays import save_trajectory
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record, Timing
from plumbline.harness.store.store import write_json
from plumbline.harness.trajectory import Floats, Trajectory

__all__ = ["CASE", "LATENCY", "scene", "sensing", "told", "write_sensor_folder"]

CASE = "sensor_planted"
RATE, COUNT = 100.0, 6000
LATENCY = 0.03
WHITE = AxisNoise(density=2e-3, bias=0.02)
BEAMS = (8, 64)
PIXELS = (24, 32)
SCANS = 10


def scene() -> Scene:
    """A carrier that swings about z, with one sensor of each kind."""
    carrier = Body(name="carrier", visual=(PlacedShape(shape=Sphere(radius=0.1)),), p_WB=(1.0, 2.0, 3.0))
    noise = ImuNoise(accelerometer=WHITE, gyroscope=WHITE)
    imu = Imu(name="imu", body="carrier", rate=RATE, p_BS=(0.2, 0.0, 0.0), latency=LATENCY, reading="states", noise=noise)
    finder = Lidar(
        name="lidar",
        body="carrier",
        rate=10.0,
        channels=BEAMS[0],
        columns=BEAMS[1],
        noise=LidarNoise(range_sigma=0.02, dropout=0.1, intensity_sigma=0.01),
    )
    size: dict[str, Any] = {"height": PIXELS[0], "width": PIXELS[1], "focal_x": 30.0, "focal_y": 30.0}
    middle: dict[str, Any] = {"centre_x": 16.0, "centre_y": 12.0}
    stereo = StereoNoise(baseline=0.1, disparity_sigma=0.02, occlusion=False, missing=0.05)
    depth = DepthCamera(name="depth", body="carrier", rate=10.0, far=20.0, noise=stereo, **size, **middle)
    camera = Camera(name="camera", body="carrier", rate=10.0, **size, **middle)
    return Scene(bodies=(carrier,), sensors=(imu, finder, depth, camera))


def swinging(time: Floats) -> tuple[Floats, Floats]:
    """Angle [rad] and rate [rad/s] about z."""
    return 0.8 * np.sin(1.3 * time), 1.04 * np.cos(1.3 * time)


def _felt(time: Floats) -> tuple[Floats, Floats]:
    """Specific force and rate at S, each (k, 3), without delay."""
    _, rate = swinging(time)
    change = -1.352 * np.sin(1.3 * time)
    zero = np.zeros_like(time)
    force = np.stack([-0.2 * rate**2, 0.2 * change, np.full_like(time, 9.81)], axis=1)
    return force, np.stack([zero, zero, rate], axis=1)


def told() -> dict[str, Floats]:
    """Ideal streams of the truth."""
    stamps = np.arange(1, COUNT + 1) / RATE
    force, rate = _felt(stamps - LATENCY)
    mean_force = _felt(stamps - LATENCY - 0.5 / RATE)[0]
    scans, frames = np.arange(SCANS) / 10.0, np.arange(SCANS) / 10.0
    ranges = np.broadcast_to(np.linspace(2.0, 8.0, BEAMS[1]), (SCANS, *BEAMS)).copy()
    ranges[:, 0, :8] = np.inf
    rows, columns = np.meshgrid(np.arange(PIXELS[0]), np.arange(PIXELS[1]), indexing="ij")
    depth = np.broadcast_to(2.0 + 0.2 * columns, (SCANS, *PIXELS)).copy()
    colour = np.broadcast_to(np.stack([rows / 24.0, columns / 32.0, 0.5 + 0 * rows], axis=-1), (SCANS, *PIXELS, 3))
    del force
    return {
        "imu/time": stamps,
        "imu/accelerometer_ideal": mean_force,
        "imu/gyroscope_ideal": rate,
        "lidar/time": scans,
        "lidar/range_ideal": ranges,
        "lidar/intensity_ideal": np.where(np.isinf(ranges), 0.0, 0.5),
        "depth/time": frames,
        "depth/depth_ideal": depth,
        "camera/time": frames,
        "camera/colour": colour.copy(),
        "camera/depth": depth,
        "camera/body": np.zeros((SCANS, *PIXELS)),
    }


def sensing(seed: int, *, louder: float = 1.0, dropout: float = 0.1, off: float = 0.0, late: float = 0.0) -> Trajectory:
    """What an engine would answer: noise `louder` than its law, returns lost at `dropout`, ranges and rates off by `off`."""
    rng, streams = np.random.default_rng(seed), told()
    stamps = streams["imu/time"]
    streams["imu/gyroscope_ideal"] = _felt(stamps - LATENCY - late)[1] + off
    for channel in ("accelerometer", "gyroscope"):
        ideal = streams[f"imu/{channel}_ideal"]
        white = WHITE.density * np.sqrt(RATE) * louder * rng.standard_normal(ideal.shape)
        streams[f"imu/{channel}"] = ideal + WHITE.bias + white
    streams["lidar/range_ideal"] = streams["lidar/range_ideal"] + off
    ranges = streams["lidar/range_ideal"]
    lost = rng.random(ranges.shape) < dropout
    streams["lidar/range"] = np.where(lost, np.inf, ranges + 0.02 * louder * rng.standard_normal(ranges.shape))
    bright = streams["lidar/intensity_ideal"] + 0.01 * rng.standard_normal(ranges.shape)
    streams["lidar/intensity"] = np.where(np.isinf(streams["lidar/range"]), 0.0, bright)
    depth = streams["depth/depth_ideal"]
    sigma = depth**2 * 0.02 / (30.0 * 0.1)
    read = depth + louder * sigma * rng.standard_normal(depth.shape)
    streams["depth/depth"] = np.where(rng.random(depth.shape) < 0.05, np.nan, read)
    points = np.where(np.isfinite(streams["lidar/range"]), streams["lidar/range"], np.nan)[..., None]
    streams["lidar/points"] = points * np.array([1.0, 0.0, 0.0])
    return _at_samples(streams)


def _at_samples(streams: dict[str, Floats]) -> Trajectory:
    time = np.arange(1201) * 0.05
    run = Trajectory.of(time, 1)
    angle, rate = swinging(time)
    run.p_WB[:, 0] = (1.0, 2.0, 3.0)
    run.q_WB[:, 0, 0], run.q_WB[:, 0, 3] = np.cos(angle / 2), np.sin(angle / 2)
    run.w_WB[:, 0, 2] = rate
    return dataclasses.replace(run, dt=0.01, streams=streams)


def _record(engine: str, **changes: Any) -> Record:
    # The last bit of a sine may differ from machine to machine, so the name does not follow from what was read.
    name = hashlib.sha256(repr((engine, changes.get("experiment"))).encode()).hexdigest()[:16]
    plain: dict[str, Any] = {
        "trial": name,
        "study": "sensors",
        "experiment": "signals",
        "case": CASE,
        "parameters": {},
        "engine": engine,
        "engine_version": "1.0",
        "track": "tuned",
        "dt": 0.01,
        "settings": {"dt": 0.01},
        "status": "passed",
        "reason": "every check holds",
    }
    return Record(**(plain | changes))


def write_sensor_folder(path: Path) -> Path:
    """A clean engine, one with planted faults, one that cannot, one that diverged; and what the clock found of the first."""
    path.mkdir(parents=True, exist_ok=True)
    journal, stage = Journal(path), scene()
    truth = _at_samples(told())
    for engine, seed, faults, error in (
        ("reference", 1, {}, 0.0),
        ("mujoco", 2, {"louder": 2.0, "dropout": 0.3, "off": 1e-3}, 1e-3),
    ):
        checks = tuple(
            Measurement(metric=metric, value=error, unit=unit, at_most=1e-6, passed=error < 1e-6, because="planted")
            for metric, unit in (("gyroscope_ideal_error", "rad/s"), ("range_error_max", "m"))
        )
        kept = save_trajectory(path, stage, sensing(seed, **faults), truth)
        record = _record(engine, trajectory_hash=kept, clocks="sensing", measurements=checks)
        journal.append(record)
        journal.append(
            Timing(trial=record.trial, unit="sensing", cpu_per_unit=2e-3, cpu_per_unit_low=1e-3, cpu_per_unit_high=3e-3)
        )
    bare = _record("reference", trajectory_hash=None, clocks="casting", experiment="beams", status="failed")
    journal.append(bare)
    journal.append(Timing(trial=bare.trial, unit="ray", cpu_per_unit=1e-7, cpu_per_unit_low=1e-7, cpu_per_unit_high=1e-7))
    journal.append(_record("bullet", status="unsupported", reason="image of camera 'camera': no renderer"))
    journal.append(_record("dart", status="diverged", reason="by step 3 of 9: the state is not finite"))
    journal.close()
    case = {"name": CASE, "family": "sensor", "title": "Planted sensors", "effects": ["sensing"], "dt": 0.01, "parameters": {}}
    case |= {"question": "Is what was planted found?", "headline": "range_error_max"}
    engines = {
        name: {"name": name, "title": name.title(), "ours": name == "reference"}
        for name in ("reference", "mujoco", "bullet", "dart")
    }
    write_json(path / "catalogue.json", {"cases": {CASE: case}, "engines": engines})
    return path
