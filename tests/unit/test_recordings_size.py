"""What a pose weighs in a recording, and that nothing which can be seen is lost for it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr

from plumbline.harness.scene import Body, Box, Scene, Sphere
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Trajectory
from plumbline.reports.recordings.bodies import log_moving, sharing
from plumbline.reports.recordings.runs import FRAMES, WATCH, extremes, shown, stage_of
from plumbline.reports.recordings.shapes import Paint
from tests.recorded_folder import LAW, Folder, Read, placed, record

DT, BYTES = 1 / 240, 40.0


def tumbling(bodies: int, instants: int) -> tuple[Scene, Trajectory]:
    """Bodies that all move and turn as they like, so that no number follows from another; boxes and spheres by turns."""
    shapes = Box(half_extents=(0.1, 0.2, 0.3)), Sphere(radius=0.1)
    scene = Scene(
        bodies=tuple(Body(name=f"b{k}", mass=1.0, collision=placed(shapes[k % 2])) for k in range(bodies)), surfaces=(LAW,)
    )
    draw, answer = np.random.default_rng(0), Trajectory.of(np.arange(instants) * DT, bodies)
    answer.p_WB[:] = 1e-2 * np.cumsum(draw.normal(size=answer.p_WB.shape), axis=0)
    turns = np.array([1.0, 0, 0, 0]) + 1e-2 * np.cumsum(draw.normal(size=answer.q_WB.shape), axis=0)
    answer.q_WB[:] = turns / np.linalg.norm(turns, axis=2, keepdims=True)
    answer.v_WB[:], answer.w_WB[:] = draw.normal(size=answer.v_WB.shape), draw.normal(size=answer.w_WB.shape)
    return scene, replace(answer, dt=DT)


def as_written(scene: Scene) -> list[Mapping[str, Any]]:
    """The bodies as a scene file has them."""
    bodies: list[Mapping[str, Any]] = [
        {"name": body.name, "collision": [{"shape": {"type": "box", "half_extents": (0.1, 0.2, 0.3)}}]} for body in scene.bodies
    ]
    return bodies


def written(folder: Path, bodies: int, instants: int) -> Path:
    run = Folder(folder / f"{bodies}_{instants}")
    run.add(record("tumble", "mujoco", dt=DT), *tumbling(bodies, instants))
    return run.write()[0]


def test_a_pose_takes_at_most_forty_bytes_of_the_whole_file(tmp_path: Path) -> None:
    """Forty bodies over 1000 instants: the file with its layout, text, curves and shapes over the poses that it holds.

    A pose is seven numbers of four bytes, 28; to them comes a share of what each row and the file have of their own.
    """
    path = written(tmp_path, 40, 1000)
    read = Read(path)
    held = [read.array(f"/world/mujoco/tuned/{kind}", "InstancePoses3D:translations") for kind in ("box", "sphere")]
    assert path.stat().st_size / sum(poses.size // 3 for poses in held) <= BYTES


@pytest.mark.parametrize(("bodies", "most"), [(1, 43.0), (2, 36.0), (10, 31.0)])
def test_a_pose_more_takes_its_numbers_and_a_share_of_its_row(tmp_path: Path, bodies: int, most: float) -> None:
    """Poses alone, as they lie on the disk: 700 instants against 350, by how much the file is the larger over its poses more.

    Without curves, ways and contacts, of which a run has as many whether one body moves or a hundred. A row's number takes 4
    bytes, its time 6 to 7 and its offset 4, which its bodies share: 28 + 15 / bodies at most, and a byte for LZ4's tokens. Of
    these bodies no number follows from another; one of them alone takes more than 40.
    """
    sizes = []
    for instants in (350, 700):
        scene, moved = tumbling(2 * bodies, instants)
        rec = rr.RecordingStream("plumbline-poses", send_properties=False)
        rec.set_log_time_enabled(False)
        rec.set_log_tick_enabled(False)
        path = tmp_path / f"{instants}.rrd"
        rec.save(path)
        arrays = {"time": moved.time, "p_WB": moved.p_WB, "q_WB": moved.q_WB}
        boxes = list(range(0, 2 * bodies, 2))
        log_moving(rec, "world", sharing(as_written(scene), boxes), arrays, Paint((0, 0, 0, 255), 1.0))
        rec.flush()
        rec.disconnect()
        sizes.append(path.stat().st_size)
    assert (sizes[1] - sizes[0]) / (bodies * 350) <= most


def test_a_recording_holds_the_poses_of_the_trajectory_to_single_precision(tmp_path: Path) -> None:
    scene, truth = tumbling(6, 50)
    read = Read(written(tmp_path, 6, 50))
    for k, kind in enumerate(("box", "sphere")):
        p = read.array(f"/world/mujoco/tuned/{kind}", "InstancePoses3D:translations")
        q = read.array(f"/world/mujoco/tuned/{kind}", "InstancePoses3D:quaternions")
        # Half a unit in the last place of single precision is 2^-24 of a number.
        assert p == pytest.approx(truth.p_WB[:, k::2], rel=2**-24, abs=1e-30)
        assert q == pytest.approx(truth.q_WB[:, k::2, [1, 2, 3, 0]], rel=2**-24, abs=1e-30)
    assert {body.name for body in scene.bodies} == {
        name for kind, shape in (("box", "Boxes3D"), ("sphere", "Ellipsoids3D"))
        for name in read.column(f"/world/mujoco/tuned/{kind}", f"{shape}:labels")[0]
    }  # fmt: skip


@pytest.mark.parametrize("still", ["places", "turns", "both"])
def test_a_row_says_all_of_a_pose_and_one_row_will_do_for_what_rests(tmp_path: Path, still: str) -> None:
    """A viewer takes a pose from one row: what is said elsewhere, if only once for all, is lost to it."""
    scene, moved = tumbling(2, 50)
    if still != "turns":
        moved.p_WB[:] = moved.p_WB[:1]
    if still != "places":
        moved.q_WB[:] = moved.q_WB[:1]
    run = Folder(tmp_path / "run")
    run.add(record("slide", "mujoco", dt=DT), scene, moved)
    read = Read(run.write()[0])
    rows = 1 if still == "both" else 50
    p = read.array("/world/mujoco/tuned/box", "InstancePoses3D:translations")
    q = read.array("/world/mujoco/tuned/box", "InstancePoses3D:quaternions")
    assert p == pytest.approx(moved.p_WB[:rows, ::2], rel=2**-24, abs=1e-30)
    assert q == pytest.approx(moved.q_WB[:rows, ::2, [1, 2, 3, 0]], rel=2**-24, abs=1e-30)
    chunks = read.chunks["/world/mujoco/tuned/box"]
    posed = [{name for name in chunk.schema.names if name.startswith("InstancePoses3D:")} for chunk in chunks]
    assert {frozenset(names) for names in posed if names} == {
        frozenset({"InstancePoses3D:translations", "InstancePoses3D:quaternions"})
    }


@pytest.mark.parametrize(("length", "rate"), [(0.01, 1e6), (2.0, 240.0), (60.0, 240.0), (60.0, 100.0), (3.0, 20.0)])
def test_the_viewer_has_an_instant_for_each_of_its_frames_where_there_are_so_many(length: float, rate: float) -> None:
    time = np.arange(round(length * rate) + 1) / rate
    places = shown(time, length)
    frames = FRAMES * min(max(length, WATCH[0]), WATCH[1])
    assert places[0] == 0
    assert places[-1] == len(time) - 1
    assert min(frames, len(time) - 1) <= len(places) - 1 + 1 <= 2 * frames + 2
    assert np.diff(places).max() == np.diff(places)[0]


@pytest.mark.parametrize("stride", [1, 3, 7])
def test_a_thinned_curve_keeps_every_peak_and_dip(tmp_path: Path, stride: int) -> None:
    values = np.random.default_rng(1).normal(size=1000)
    values[437], values[612] = 50.0, -60.0
    kept = extremes(values, stride)
    assert {0, 437, 612, 999} <= set(kept.tolist())
    assert (np.diff(kept) > 0).all()
    assert len(kept) <= 1000 / stride + 2 * stride + 2
    for start in range(0, 1000 - 2 * stride, 2 * stride):
        block = values[start : start + 2 * stride]
        here = values[kept[(kept >= start) & (kept < start + 2 * stride)]]
        assert (here.min(), here.max()) == (block.min(), block.max())


def test_contacts_are_shown_at_the_instants_of_the_poses(tmp_path: Path) -> None:
    scene, moved = tumbling(2, 3000)
    run = Folder(tmp_path / "run")
    run.add(record("long", "mujoco", dt=DT), scene, moved)
    path = run.write()[0]
    stage = stage_of(Store(run.path), "long")
    run_of, places = stage.runs[0], shown(stage.runs[0].time, stage.length)
    seconds = [stamp.total_seconds() for stamp in Read(path).column("/world/mujoco/tuned/box", "sim_time")]
    assert seconds == pytest.approx(run_of.time[places], abs=1e-6)
    assert 720 < len(seconds) < 1500
