"""Recordings: what stands in the files is what stood in the store, and nothing is left out without a word."""

import dataclasses
import hashlib
import json
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from rerun.chunk import RrdReader

from harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Imu,
    Lidar,
    PlacedShape,
    Plane,
    Scene,
    Sphere,
    Surface,
    TriangleMesh,
)
from harness.store.journal import Journal
from harness.store.record import Measurement, Record
from harness.store.store import Store, StoreError
from harness.store.trajectory_file import save_trajectory
from harness.trajectory import Contacts, Trajectory
from reports import open_viewer, recording_of, write_recordings
from reports.palette import ENGINES
from reports.recordings.camera import framed, framing
from reports.recordings.rotation import angle, compose
from reports.recordings.runs import stage_of
from reports.recordings.shapes import CROWD
from reports.recordings.truth import truth_at
from reports.viewer import viewer_command

CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
QUARTER = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
LAW = Surface()
TIMES = np.arange(11) / 100.0
STATUSES = ("passed", "failed", "diverged", "unsupported", "unavailable", "timeout", "crashed", "oom", "interrupted")


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
        (self.path / "catalogue.json").write_text(json.dumps({"cases": cases, "engines": {}}), encoding="utf-8")
        self.journal.close()
        return write_recordings(self.path)


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path / "run")


class Read:
    """A recording read back: rows of each path by component."""

    def __init__(self, path: Path) -> None:
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


def test_every_recording_is_whole_and_stands_under_its_case_alone(folder: Folder) -> None:
    for case in ("rise_zoo", "rise_again"):
        folder.add(record(case, "mujoco"), zoo(), rising(zoo()), rising(zoo(), 2.0))
    paths = folder.write()
    assert [path.name for path in paths] == ["rise_again.rrd", "rise_zoo.rrd"]
    assert sorted(path.name for path in (folder.path / "recordings").iterdir()) == ["rise_again.rrd", "rise_zoo.rrd"]
    verdict = subprocess.run(
        [*viewer_command(), "rrd", "verify", *map(str, paths)], capture_output=True, text=True, check=False
    )
    assert verdict.returncode == 0, verdict.stderr


def test_each_engine_and_track_and_the_truth_have_one_pose_a_body_and_instant(folder: Folder) -> None:
    scene = zoo()
    for engine, track in (("mujoco", "tuned"), ("mujoco", "default"), ("bullet", "tuned")):
        folder.add(record("rise", engine, track), scene, rising(scene, 1.5), rising(scene))
    read = Read(folder.write()[0])
    expected = [[[3.0, 0.0, pytest.approx(1.0 + 1.5 * t, abs=1e-6)]] for t in TIMES]
    for run in ("mujoco/tuned", "mujoco/default", "bullet/tuned"):
        assert read.column(f"/world/{run}/drum", "InstancePoses3D:translations") == expected
    ghost = [[[3.0, 0.0, pytest.approx(1.0 + t, abs=1e-6)]] for t in TIMES]
    assert read.column("/world/truth/drum", "InstancePoses3D:translations") == ghost
    assert read.column("/world/mujoco/tuned/drum", "step") == list(range(11))
    seconds = [stamp.total_seconds() for stamp in read.column("/world/mujoco/tuned/drum", "sim_time")]
    assert seconds == pytest.approx(TIMES)


def test_all_eight_shapes_are_drawn_with_their_sizes(folder: Folder) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    root = "/world/mujoco/tuned"
    assert read.array(f"{root}/ball", "Ellipsoids3D:half_sizes")[0] == pytest.approx(np.full((1, 3), 0.1))
    assert read.array(f"{root}/brick", "Boxes3D:half_sizes")[0] == pytest.approx(np.array([[0.1, 0.2, 0.3]]))
    assert read.array(f"{root}/pill", "Capsules3D:lengths")[0] == pytest.approx([0.5])
    # The viewer's capsule starts at its origin; ours is centred there.
    assert read.array(f"{root}/pill", "Capsules3D:translations")[0] == pytest.approx(np.array([[0.0, 0.0, -0.25]]))
    assert read.array(f"{root}/drum", "Cylinders3D:lengths")[0] == pytest.approx([0.8])
    assert read.array(f"{root}/egg", "Ellipsoids3D:half_sizes")[0] == pytest.approx(np.array([[0.1, 0.15, 0.2]]))
    for name in ("hull", "mesh"):
        corners = read.array(f"{root}/{name}", "Mesh3D:vertex_positions")[0].reshape(-1, 3, 3)
        assert {tuple(corner) for face in corners for corner in face} == set(CORNERS)
        # Facets wound outwards enclose the volume 1/6 of this tetrahedron, by the divergence theorem.
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        assert np.sum(a * np.cross(b, c)) / 6 == pytest.approx(1 / 6)
    top = read.array("/world/scene/ground", "Boxes3D:centers")[0] + read.array("/world/scene/ground", "Boxes3D:half_sizes")[0]
    assert top[0, 2] == pytest.approx(0.0, abs=1e-7)


def test_shapes_away_from_the_centre_of_mass_turn_with_their_body(folder: Folder) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo(), 0.0))
    read = Read(folder.write()[0])
    # A quarter turn about z carries +x of the body to +y of the world.
    assert read.array("/world/mujoco/tuned/dumbbell/sphere", "InstancePoses3D:translations")[0, 0] == pytest.approx([9, 0.5, 1])
    assert read.array("/world/mujoco/tuned/dumbbell/box", "InstancePoses3D:translations")[0, 0] == pytest.approx([9, -0.5, 1])
    quaternion = read.array("/world/mujoco/tuned/dumbbell/box", "InstancePoses3D:quaternions")[0, 0]
    assert quaternion == pytest.approx([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])


def test_an_engine_has_the_colour_that_it_has_in_the_report(folder: Folder) -> None:
    folder.add(record("rise", "dart"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    expected = int(ENGINES["dart"].colour[1:] + "ff", 16)
    assert read.column("/world/dart/tuned/ball", "Ellipsoids3D:colors") == [[expected]]
    assert read.column("/metrics/speed/dart/tuned", "SeriesLines:colors") == [[expected]]


def test_what_never_moves_is_written_once_for_all_engines(folder: Folder) -> None:
    for engine in ("mujoco", "bullet"):
        folder.add(record("rise", engine), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    assert [path for path in read.chunks if path.endswith("/ground")] == ["/world/scene/ground"]


def test_bodies_of_a_crowd_share_a_path_and_keep_their_order(folder: Folder) -> None:
    count = CROWD + 6
    bodies = tuple(
        Body(name=f"s{k}", collision=placed(Sphere(radius=0.1 + k)), p_WB=(float(k), 0.0, 0.0)) for k in range(count)
    )
    scene = Scene(bodies=bodies, surfaces=(LAW,))
    folder.add(record("crowd", "mujoco"), scene, rising(scene))
    read = Read(folder.write()[0])
    assert [path for path in read.chunks if path.startswith("/world/mujoco/tuned/")] == ["/world/mujoco/tuned/sphere"]
    poses = read.array("/world/mujoco/tuned/sphere", "InstancePoses3D:translations")
    assert poses.shape == (11, count, 3)
    assert poses[0, :, 0] == pytest.approx(np.arange(count))
    sizes = read.array("/world/mujoco/tuned/sphere", "Ellipsoids3D:half_sizes")[0]
    assert sizes[:, 0] == pytest.approx(0.1 + np.arange(count))


def pressing(force: float) -> tuple[Contacts, ...]:
    """One contact at even instants, of this normal force [N], and one without force."""
    pair = Contacts.of([0, 0], [1, 2], [[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, [0.0] * 2, [[0, 0, force], [0, 0, 0]])
    return tuple(pair if k % 2 == 0 else Contacts.none() for k in range(len(TIMES)))


def test_contact_forces_are_arrows_of_one_scale_and_gone_where_there_is_no_contact(folder: Folder) -> None:
    scene = zoo()
    for engine, force in (("mujoco", 10.0), ("bullet", 20.0), ("dart", 10.0)):
        folder.add(record("press", engine), scene, rising(scene, contacts=pressing(force)))
    read = Read(folder.write()[0])
    arrows = {engine: read.column(f"/world/{engine}/tuned/contacts", "Arrows3D:vectors") for engine in ("mujoco", "bullet")}
    assert [len(row) for row in arrows["mujoco"]] == [1, 0] * 5 + [1]
    assert arrows["mujoco"][0][0][:2] == [0.0, 0.0]
    assert arrows["bullet"][0][0][2] == pytest.approx(2 * arrows["mujoco"][0][0][2], rel=1e-6)
    # The median engine's largest force is a quarter as long as the picture is wide.
    size = framing(stage_of(Store(folder.path), "press")).size
    assert arrows["mujoco"][0][0][2] == pytest.approx(size / 4, rel=1e-6)
    assert f"1 m of arrow is {10.0 / arrows['mujoco'][0][0][2]:.3g} N" in read.text()


def test_plots_hold_what_the_states_say(folder: Folder) -> None:
    scene = Scene(bodies=(Body(name="ball", mass=2.0, inertia=((1.5, 0, 0), (0, 2, 0.5), (0, 0.5, 2.5)), q_WB=QUARTER),))
    actual = rising(scene, 3.0)
    actual.w_WB[:] = [2.0, 0.0, 1.0]
    folder.add(record("rise", "mujoco"), scene, actual, rising(scene))
    read = Read(folder.write()[0])
    # m v^2/2 = 9 J; turned by a quarter about z, the world's x is the body's -y: w = (0, -2, 1) in the body, and
    # w I w/2 = (2 * 4 - 2 * 0.5 * 2 * 1 + 2.5 * 1) / 2 = 4.25 J.
    assert read.array("/metrics/kinetic_energy/mujoco/tuned", "Scalars:scalars") == pytest.approx(np.full((11, 1), 13.25))
    assert read.array("/metrics/speed/mujoco/tuned", "Scalars:scalars") == pytest.approx(np.full((11, 1), 3.0))
    error = read.array("/metrics/position_error/mujoco/tuned", "Scalars:scalars")
    assert error[:, 0] == pytest.approx(2.0 * TIMES, abs=1e-12)
    assert read.array("/metrics/speed/truth", "Scalars:scalars") == pytest.approx(np.ones((11, 1)))


def test_a_diverged_run_is_shown_as_far_as_it_is_finite_and_says_why(folder: Folder) -> None:
    actual = rising(zoo())
    actual.v_WB[7:, 2, 0] = np.nan
    reason = "by step 7 of 10: a state is not finite"
    folder.add(record("rise", "mujoco", status="diverged", reason=reason), zoo(), actual, rising(zoo()))
    folder.add(record("rise", "bullet"), zoo(), rising(zoo()), rising(zoo()))
    read = Read(folder.write()[0])
    assert len(read.column("/world/mujoco/tuned/ball", "InstancePoses3D:translations")) == 7
    assert len(read.column("/world/bullet/tuned/ball", "InstancePoses3D:translations")) == 11
    row = next(line for line in read.text().splitlines() if line.startswith("| mujoco"))
    assert "diverged" in row
    assert reason in row
    assert "shown up to instant 7 of 11" in row


def test_every_outcome_is_listed_and_a_case_without_any_trajectory_has_its_text(folder: Folder) -> None:
    for status in STATUSES:
        folder.add(record("void", "mujoco", status=status, reason=f"because of | {status}"))
    read = Read(folder.write(void={"title": "Nothing"})[0])
    rows = [line for line in read.text().splitlines() if line.startswith("| mujoco")]
    assert len(rows) == len(STATUSES)
    for status in STATUSES:
        # A bar within a reason must not open another cell.
        assert any(f"because of \\| {status}" in row and f"| {status} |" in row for row in rows)
    assert "nothing can be drawn" in read.text()
    assert not [path for path in read.chunks if path.startswith(("/world/mujoco", "/metrics"))]


def test_a_trajectory_that_cannot_be_read_is_named_and_the_others_are_shown(folder: Folder) -> None:
    folder.add(record("rise", "mujoco", trajectory_hash="0123456789abcdef"))
    folder.add(record("rise", "dart"), zoo(), rising(zoo(), 7.0))
    (torn,) = (folder.path / "trajectories").iterdir()
    torn.write_bytes(torn.read_bytes()[:1000])
    folder.add(record("rise", "bullet"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    for engine, name in (("mujoco", "0123456789abcdef"), ("dart", torn.stem)):
        row = next(line for line in read.text().splitlines() if line.startswith(f"| {engine}"))
        assert "| no |" in row
        assert f"trajectory {name} is not readable" in row
    assert "/world/bullet/tuned/ball" in read.chunks
    assert "/world/dart/tuned/ball" not in read.chunks


def test_of_many_time_steps_the_one_of_the_case_is_shown_and_the_others_are_listed(folder: Folder) -> None:
    for dt in (0.04, 0.01, 0.0025):
        folder.add(record("rise", "mujoco", dt=dt), zoo(), dataclasses.replace(rising(zoo(), 100 * dt), dt=dt))
    read = Read(folder.write(rise={"dt": 0.01, "parameters": {"mass": 2.0}})[0])
    assert read.column("/metrics/speed/mujoco/tuned", "Scalars:scalars")[0] == [pytest.approx(1.0)]
    rows = [line for line in read.text().splitlines() if line.startswith("| mujoco")]
    assert len(rows) == 3
    assert [("| yes |" in row) for row in rows] == [True, False, False]


def test_a_run_that_flies_away_does_not_take_the_view_along(folder: Folder) -> None:
    for engine, speed in (("mujoco", 1.0), ("bullet", 1.01), ("dart", 1e9)):
        folder.add(record("rise", engine), zoo(), rising(zoo(), speed))
    folder.write()
    frame = framing(stage_of(Store(folder.path), "rise"))
    # The bodies lie between x = -0.1 and 10, and rise by 0.1 m.
    assert np.linalg.norm(frame.eye) < 50
    assert frame.radius < 10


def test_runs_of_other_parameters_never_share_a_scene(folder: Folder) -> None:
    folder.add(record("rise", "mujoco", parameters={"mass": 5.0}), zoo(), rising(zoo()))
    folder.add(record("rise", "bullet"), zoo(), rising(zoo()))
    read = Read(folder.write(rise={"dt": 0.01, "parameters": {"mass": 2.0}})[0])
    assert "/world/bullet/tuned/ball" in read.chunks
    assert "/world/mujoco/tuned/ball" not in read.chunks


def sensing() -> tuple[Scene, Trajectory]:
    """A carrier with an inertial sensor and a scan of four beams, of which one returns nothing."""
    carrier = Body(name="carrier", visual=placed(Sphere(radius=0.1)), p_WB=(1.0, 2.0, 3.0), q_WB=QUARTER)
    lidar = Lidar(name="lidar", body="carrier", rate=10.0, channels=1, columns=4, elevation_low=0.0, elevation_high=0.0)
    scene = Scene(bodies=(carrier,), sensors=(Imu(name="imu", body="carrier", rate=100.0), lidar))
    ranges = np.array([[[2.0, 3.0, np.inf, 4.0]]] * 2)
    signal = np.arange(30.0).reshape(10, 3)
    streams = {"imu/time": TIMES[1:], "imu/accelerometer": signal, "imu/gyroscope": -signal}
    streams |= {"lidar/time": np.array([0.0, 0.1]), "lidar/range": ranges, "lidar/range_ideal": ranges}
    return scene, rising(scene, 0.0, streams=streams)


def test_inertial_signals_are_plotted_axis_by_axis_at_their_stamps(folder: Folder) -> None:
    scene, actual = sensing()
    folder.add(record("sense", "mujoco"), scene, actual)
    read = Read(folder.write()[0])
    assert read.array("/sensors/imu/accelerometer/mujoco/tuned", "Scalars:scalars") == pytest.approx(
        np.arange(30.0).reshape(10, 3)
    )
    seconds = [stamp.total_seconds() for stamp in read.column("/sensors/imu/gyroscope/mujoco/tuned", "sim_time")]
    assert seconds == pytest.approx(TIMES[1:])


def test_a_scan_is_a_cloud_where_its_beams_ended_in_the_world(folder: Folder) -> None:
    scene, actual = sensing()
    folder.add(record("sense", "mujoco"), scene, actual)
    read = Read(folder.write()[0])
    clouds = read.column("/sensors/lidar/points/mujoco/tuned", "Points3D:positions")
    # Beams along +x, +y, -x, -y of the carrier, which a quarter turn about z lays along +y, -x, -y, +x; the third saw nothing.
    expected = [[1.0, 4.0, 3.0], [-2.0, 2.0, 3.0], [5.0, 2.0, 3.0]]
    assert np.array(clouds) == pytest.approx(np.array([expected, expected]), abs=1e-6)


def test_a_second_writing_gives_the_same_content(folder: Folder) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()), rising(zoo()))
    path = folder.write()[0]
    first = RrdReader(path).store().summary()
    columns = {
        where: batches[0].drop_columns(["rerun.controls.RowId"]).to_pydict() for where, batches in Read(path).chunks.items()
    }
    write_recordings(folder.path)
    again = Read(path)
    assert again.store.summary() == first
    for where, batches in again.chunks.items():
        assert batches[0].drop_columns(["rerun.controls.RowId"]).to_pydict() == columns[where], where


def test_names_that_are_no_file_names_stay_within_the_folder(folder: Folder) -> None:
    folder.add(record("../../escape", "a/b <c>"), zoo(), rising(zoo()))
    path = folder.write()[0]
    assert path.parent == folder.path / "recordings"
    assert recording_of(folder.path, "../../escape") == path


def test_a_missing_recording_is_told_with_those_that_exist(folder: Folder, tmp_path: Path) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()))
    folder.write()
    assert recording_of(folder.path, "rise").is_file()
    with pytest.raises(StoreError, match="no recording of case 'fall'; there are: rise"):
        recording_of(folder.path, "fall")
    with pytest.raises(StoreError, match="no run folder"):
        recording_of(tmp_path, "rise")


def test_without_a_display_the_viewer_says_what_to_do(
    folder: Folder, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert open_viewer(folder.path / "recordings" / "rise.rrd") == 3
    assert f"plumbline serve {folder.path}" in capsys.readouterr().err


def test_the_truth_between_its_instants_is_interpolated_and_untold_parts_spoil_no_others() -> None:
    p_WB = np.array([[[0.0, 0, 0]], [[1.0, 0, 0]], [[np.nan, 0, 0]]])
    truth = {"time": np.array([0.0, 1.0, 2.0]), "p_WB": p_WB, "q_WB": np.tile([1.0, 0, 0, 0], (3, 1, 1))}
    kept, p, _ = truth_at(truth, np.array([0.25, 1.0, 1.5, 2.5]))
    assert kept.tolist() == [0, 1, 2]
    assert p[:2, 0, 0] == pytest.approx([0.25, 1.0])
    assert np.isnan(p[2, 0, 0])


def test_a_pose_is_composed_as_by_hand_and_an_angle_is_blind_to_the_sign_of_a_quaternion() -> None:
    quarter = np.array(QUARTER)
    p, q = compose(np.array([1.0, 0, 0]), quarter, np.array([1.0, 0, 0]), quarter)
    assert p == pytest.approx([1.0, 1.0, 0.0])
    assert q == pytest.approx([0.0, 0.0, 0.0, 1.0])
    assert angle(quarter, np.array([1.0, 0, 0, 0])) == pytest.approx(np.pi / 2)
    assert angle(quarter, -quarter) == pytest.approx(0.0)


@pytest.mark.parametrize("sides", [(1, 1, 1), (5, 1, 1), (1, 60, 1), (60, 1, 1), (1, 1, 20)])
def test_the_eye_lies_outside_of_what_it_looks_at(sides: tuple[float, float, float]) -> None:
    half = np.array(sides) / 2.0
    frame = framed(-half, half)
    assert (np.abs(frame.eye) > half).any()
    assert frame.eye[2] > frame.target[2]
    assert (np.abs(frame.target) <= half + 1e-9).all()
