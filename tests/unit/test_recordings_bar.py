"""Poses of every case in a recording: forty bytes each at most, and put together again they are those of the trajectory."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from plumbline.harness.adapter import Simulation, Unsupported
from plumbline.harness.adapter.what_comes_out import Answering
from plumbline.harness.case import Case
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.scene.file import dump_json
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.simulate import simulate
from plumbline.reports.recordings.bodies import FAR, ROUNDING, log_moving, poses, sharing
from plumbline.reports.recordings.layout import Floats, compose
from plumbline.reports.recordings.runs import at_instants, shown
from plumbline.reports.recordings.shapes import Paint, ShapeBatch
from tests.recorded_folder import Read

CASES = plugins.cases()
ENGINES = ("mujoco", "bullet", "dart")

BYTES = 40.0
INSTANTS, FEWER = 240, 120
"""Of each case the beginning, of so many samples; of fewer in `make test`."""

QUICK = (
    "flight_box",
    "friction_painleve",
    "joint_conical_pendulum",
    "orbit_kepler",
    "spin_heavy_top",
    "stack_arch",
    "stand_hit",
)
"""Cases of each kind of path (alone, about a pivot, a shared mesh, a robot), the dearest a pose among them; `make test-all`
asks all."""

FEW = 30
"""Rows are packed by what they repeat of those before them: of fewer than these, what stands first is a large part."""


def moved(case: Case, engine: str, instants: int) -> Trajectory | None:
    """What an engine's default track makes of the beginning of a case; None of one that it cannot express."""
    adapter, scene = plugins.adapter(engine), replace(case.scene(case.parameters), sensors=())
    try:
        simulation: Simulation = Answering(adapter.build(scene, replace(adapter.tracks["default"], dt=case.dt)), scene)
    except Unsupported:
        return None
    control = acting(scene, None if case.control is None else case.control(case.parameters))
    if control is not None:
        simulation = Controlled(simulation, control, case.dt, len(scene.bodies))
    try:
        answer, _ = simulate(
            simulation,
            scene,
            pace=Pace(case.dt),
            duration=min(case.duration, instants * max(case.sample_interval, case.dt)),
            sample_interval=case.sample_interval,
            with_contacts=False,
            seed=0,
        )
    finally:
        simulation.close()
    return answer


def seen_of(case: Case, instants: int = FEWER) -> dict[str, dict[str, Floats]]:
    """By the name of each engine that can express a case, the arrays of the instants that a recording shows."""
    answers = {engine: moved(case, engine, instants) for engine in ENGINES}
    if all(answer is None for answer in answers.values()):
        answers = {"reference": moved(case, "reference", instants)}
    return {
        engine: at_instants({"time": a.time, "p_WB": a.p_WB, "q_WB": a.q_WB}, shown(a.time, float(a.time[-1])))
        for engine, a in answers.items()
        if a is not None
    }


def moving_of(case: Case) -> list[ShapeBatch]:
    """The shapes of a case's bodies that move, as recordings gather them."""
    bodies = json.loads(dump_json(case.scene(case.parameters)))["bodies"]
    return sharing(bodies, [k for k, body in enumerate(bodies) if body["motion"] != "static"])


def recorded(path: Path, moving: Sequence[ShapeBatch], runs: Mapping[str, Mapping[str, Floats]]) -> Path:
    """A recording of the bodies alone: of curves, ways and contacts a run has as many whether one moves or a hundred."""
    rec = rr.RecordingStream("plumbline-poses", send_properties=False)
    rec.set_log_time_enabled(False)
    rec.set_log_tick_enabled(False)
    rec.save(path)
    for name, arrays in runs.items():
        log_moving(rec, f"world/{name}", moving, arrays, Paint((0, 0, 0, 255), 1.0))
    rec.flush()
    rec.disconnect()
    return path


def composed(read: Read, path: str, instants: int) -> tuple[Floats, Floats]:
    """What a viewer makes of a path, (t, n, 3) m and (t, n, 4): its transform, where it has one, and its instances in it."""

    def told(name: str, size: int) -> Floats:
        rows = np.array(read.column(path, name), dtype=np.float64).reshape(len(read.column(path, name)), -1, size)
        return np.broadcast_to(rows, (instants, *rows.shape[1:])) if len(rows) == 1 else rows

    p, q = told("InstancePoses3D:translations", 3), told("InstancePoses3D:quaternions", 4)[..., [3, 0, 1, 2]]
    if not any("Transform3D:quaternion" in chunk.schema.names for chunk in read.chunks[path]):
        return p, q
    return compose(told("Transform3D:translation", 3), told("Transform3D:quaternion", 4)[..., [3, 0, 1, 2]], p, q)


def test_the_quick_ones_are_cases_with_bodies_that_move() -> None:
    assert set(QUICK) <= {name for name, case in CASES.items() if moving_of(case)}


@pytest.mark.parametrize(
    ("name", "instants"),
    [*((name, FEWER) for name in QUICK), *(pytest.param(name, INSTANTS, marks=pytest.mark.slow) for name in CASES)],
)
def test_a_pose_takes_at_most_forty_bytes_and_is_where_the_engine_put_it(name: str, instants: int, tmp_path: Path) -> None:
    """Forty: by how much all instants take more than half of them, over the poses more, with what is written once left aside.

    Where: a place, put together from what is written, is off by one rounding; that of what turns about a point by four of
    numbers up to twice as large, as `pivot_of` allows, and by one more for where a shape lies in its body.
    """
    moving = moving_of(CASES[name])
    if not moving:
        pytest.skip("nothing in it moves")
    runs = seen_of(CASES[name], instants)
    whole = recorded(tmp_path / "whole.rrd", moving, runs)
    half = {engine: {key: rows[: len(rows) // 2] for key, rows in arrays.items()} for engine, arrays in runs.items()}
    more = sum(len(batch.bodies) for batch in moving) * sum(
        len(arrays["time"]) - len(half[engine]["time"]) for engine, arrays in runs.items()
    )
    if more and max(len(arrays["time"]) for arrays in runs.values()) >= FEW:
        grown = whole.stat().st_size - recorded(tmp_path / "half.rrd", moving, half).stat().st_size
        assert grown / more <= BYTES

    read = Read(whole)
    for engine, arrays in runs.items():
        for batch in moving:
            p_WS, q_WS = poses(batch, arrays["p_WB"], arrays["q_WB"])
            p, q = composed(read, f"/world/{engine}/{batch.path}", len(p_WS))
            farthest = np.linalg.norm(arrays["p_WB"][:, batch.bodies], axis=2).max() + np.linalg.norm(batch.p_BS, axis=1).max()
            assert np.abs(p - p_WS).max() <= (4 * FAR + 1) * ROUNDING * farthest
            # Four numbers of at most 1, each of them rounded, and twice where a shape is turned in its body.
            assert np.linalg.norm(q - q_WS, axis=-1).max() <= 4 * ROUNDING


@pytest.mark.parametrize("engine", ENGINES)
def test_the_heavy_top_turns_about_its_tip_and_each_row_says_all_of_that(engine: str, tmp_path: Path) -> None:
    """A viewer takes a transform from one row; what stays the same in all of them is packed to next to nothing."""
    case = CASES["spin_heavy_top"]
    arrays = seen_of(case)[engine]
    read = Read(recorded(tmp_path / "top.rrd", moving_of(case), {engine: arrays}))
    path = f"/world/{engine}/disc"
    tips = read.array(path, "Transform3D:translation").reshape(-1, 3)
    assert tips == pytest.approx(np.zeros((len(arrays["time"]), 3)), abs=1e-7)
    assert len(np.unique(tips, axis=0)) == 1
    assert len(read.column(path, "Transform3D:quaternion")) == len(tips)
    assert read.array(path, "InstancePoses3D:translations").ravel() == pytest.approx([0.0, 0.0, 0.1], abs=1e-7)
