"""A run folder written for tests of recordings, and a recording read back."""

import dataclasses
import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Surface,
    TriangleMesh,
)
from plumbline.harness.store.arrays import save_trajectory
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.record import Measurement, Record
from plumbline.harness.store.store import write_json
from plumbline.harness.trajectory import Trajectory
from plumbline.reports.recordings import write_recordings

__all__ = ["CORNERS", "FACES", "QUARTER", "LAW", "TIMES", "placed", "zoo", "rising", "record", "Folder", "Read"]


CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
QUARTER = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
LAW = Surface()
TIMES = np.arange(11) / 100.0


def placed(shape: Any, **pose: Any) -> tuple[PlacedShape, ...]:
    return (PlacedShape(shape=shape, **pose),)


def zoo() -> Scene:
    """A body for each shape, one of two shapes, and a ground."""
    shapes = {
        "ball": Sphere(radius=0.1),
        "brick": Box(half_extents=(0.1, 0.2, 0.3)),
        "pill": Capsule(radius=0.1, half_length=0.25),
        "drum": Cylinder(radius=0.1, half_length=0.4),
        "egg": Ellipsoid(semi_axes=(0.1, 0.15, 0.2)),
        "hull": ConvexHull(vertices=CORNERS),
        "mesh": TriangleMesh(vertices=CORNERS, faces=FACES),
    }
    bodies = [Body(name="ground", motion="static", collision=placed(Plane()))]
    bodies += [
        Body(name=name, mass=2.0, collision=placed(shape), p_WB=(float(k), 0.0, 1.0))
        for k, (name, shape) in enumerate(shapes.items())
    ]
    dumbbell = (
        PlacedShape(shape=Sphere(radius=0.1), p_BS=(0.5, 0.0, 0.0)),
        PlacedShape(shape=Box(half_extents=(0.2, 0.1, 0.1)), p_BS=(-0.5, 0.0, 0.0)),
    )
    bodies.append(Body(name="dumbbell", collision=dumbbell, p_WB=(9.0, 0.0, 1.0), q_WB=QUARTER))
    return Scene(bodies=tuple(bodies), surfaces=(LAW,))


def rising(scene: Scene, speed: float = 1.0, **changes: Any) -> Trajectory:
    """All movable bodies rise with this speed [m/s] from where they start."""
    answer = Trajectory.of(TIMES, len(scene.bodies))
    for k, body in enumerate(scene.bodies):
        answer.p_WB[:, k] = body.p_WB
        answer.q_WB[:, k] = body.q_WB
        if body.movable:
            answer.p_WB[:, k, 2] += speed * TIMES
            answer.v_WB[:, k, 2] = speed
    return dataclasses.replace(answer, dt=0.01, **changes)


def record(case: str, engine: str, track: str = "tuned", **changes: Any) -> Record:
    plain: dict[str, Any] = {
        "trial": hashlib.sha256(repr((case, engine, track, sorted(changes.items(), key=str))).encode()).hexdigest()[:16],
        "study": "s",
        "experiment": "e",
        "case": case,
        "parameters": {"mass": 2.0},
        "engine": engine,
        "engine_version": "1.0",
        "track": track,
        "dt": 0.01,
        "settings": {"dt": 0.01, "iterations": 50},
        "status": "passed",
        "reason": "every check holds",
        "measurements": (Measurement(metric="position_error_max", value=0.25, unit="m", at_most=0.5, passed=True),),
    }
    return Record(**(plain | changes))


class Folder:
    """A run folder that is being written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        path.mkdir(parents=True, exist_ok=True)
        self.journal = Journal(path)

    def add(
        self, trial: Record, scene: Scene | None = None, actual: Trajectory | None = None, truth: Trajectory | None = None
    ) -> str:
        if scene is not None and actual is not None:
            trial = dataclasses.replace(trial, trajectory_hash=save_trajectory(self.path, scene, actual, truth))
        self.journal.append(trial)
        return trial.trial

    def write(self, **cases: Mapping[str, Any]) -> tuple[Path, ...]:
        write_json(self.path / "catalogue.json", {"cases": cases, "engines": {}})
        self.journal.close()
        return write_recordings(self.path)


class Read:
    """A recording read back: rows of each path by component."""

    def __init__(self, path: Path) -> None:
        from rerun.chunk import RrdReader  # late: few of the files that are collected read a recording

        self.store = RrdReader(path).store()
        self.chunks: dict[str, list[pa.RecordBatch]] = {}
        for chunk in RrdReader(path).stream():
            self.chunks.setdefault(str(chunk.entity_path), []).append(chunk.to_record_batch())

    def column(self, path: str, component: str) -> list[Any]:
        """The rows of a component, in the order of the file."""
        return [
            row for batch in self.chunks[path] if component in batch.schema.names for row in batch.column(component).to_pylist()
        ]

    def array(self, path: str, component: str) -> Any:
        return np.array(self.column(path, component))

    def text(self) -> str:
        return str(self.column("/log", "TextDocument:text")[0][0])
