"""Recordings: what stands in the files is what stood in the store."""

import dataclasses
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.components import FillMode

from plumbline.harness.scene import (
    Body,
    Imu,
    Lidar,
    Scene,
    Sphere,
)
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Contacts, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between
from plumbline.reports.charts.marks import ENGINES
from plumbline.reports.recordings import write_recordings
from plumbline.reports.recordings.blueprint import layout
from plumbline.reports.recordings.bodies import truth_at
from plumbline.reports.recordings.camera import framed, framing
from plumbline.reports.recordings.layout import compose
from plumbline.reports.recordings.runs import stage_of
from plumbline.reports.recordings.shapes import CROWD, OVERLAID
from plumbline.reports.recordings.viewer import viewer_command
from tests.recorded_folder import CORNERS, LAW, QUARTER, TIMES, Folder, Read, placed, record, rising, zoo


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path / "run")


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
        assert read.column(f"/world/{run}/cylinder", "InstancePoses3D:translations") == expected
    ghost = [[[3.0, 0.0, pytest.approx(1.0 + t, abs=1e-6)]] for t in TIMES]
    assert read.column("/world/truth/cylinder", "InstancePoses3D:translations") == ghost
    seconds = [stamp.total_seconds() for stamp in read.column("/world/mujoco/tuned/cylinder", "sim_time")]
    assert seconds == pytest.approx(TIMES)


def test_all_eight_shapes_are_drawn_with_their_sizes(folder: Folder) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    root = "/world/mujoco/tuned"
    assert read.column(f"{root}/box", "Boxes3D:labels") == [["brick", "dumbbell"]]
    assert read.array(f"{root}/sphere", "Ellipsoids3D:half_sizes")[0] == pytest.approx(np.full((2, 3), 0.1))
    assert read.array(f"{root}/box", "Boxes3D:half_sizes")[0] == pytest.approx(np.array([[0.1, 0.2, 0.3], [0.2, 0.1, 0.1]]))
    assert read.array(f"{root}/capsule", "Capsules3D:lengths")[0] == pytest.approx([0.5])
    # The viewer's capsule starts at its origin; ours is centred there.
    assert read.array(f"{root}/capsule", "Capsules3D:translations")[0] == pytest.approx(np.array([[0.0, 0.0, -0.25]]))
    assert read.array(f"{root}/cylinder", "Cylinders3D:lengths")[0] == pytest.approx([0.8])
    assert read.array(f"{root}/ellipsoid", "Ellipsoids3D:half_sizes")[0] == pytest.approx(np.array([[0.1, 0.15, 0.2]]))
    for name in ("hull/convex_hull_0", "mesh/triangle_mesh_0"):
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
    assert read.array("/world/mujoco/tuned/sphere", "InstancePoses3D:translations")[0, 1] == pytest.approx([9, 0.5, 1])
    assert read.array("/world/mujoco/tuned/box", "InstancePoses3D:translations")[0, 1] == pytest.approx([9, -0.5, 1])
    quaternion = read.array("/world/mujoco/tuned/box", "InstancePoses3D:quaternions")[0, 1]
    assert quaternion == pytest.approx([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])


def test_an_engine_has_the_colour_that_it_has_in_the_report(folder: Folder) -> None:
    folder.add(record("rise", "dart"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    expected = int(ENGINES["dart"].colour[1:] + "ff", 16)
    assert read.column("/world/dart/tuned/sphere", "Ellipsoids3D:colors") == [[expected]]
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


@pytest.mark.parametrize("contacts", [True, False])
def test_how_solids_are_filled_is_said_once_with_the_shapes_or_by_each_view(folder: Folder, contacts: bool) -> None:
    """Arrows of contacts stand within solids, so that no view shows these opaque; elsewhere an engine by itself is solid."""
    scene = zoo()
    for engine in ("mujoco", "bullet"):
        folder.add(record("fill", engine), scene, rising(scene, contacts=pressing(1.0) if contacts else None))
    path = folder.write()[0]
    stage = stage_of(Store(folder.path), "fill")
    root: Any = layout(stage, framing(stage), []).root_container
    *together, side_by_side = root.contents[0].contents
    filled = {
        name: {int(default.as_arrow_array()[0].as_py()) for view in views for default in view.defaults}
        for name, views in (("together", together), ("alone", side_by_side.contents))
    }
    modes = {name: {FillMode.auto(name).value} for name in (OVERLAID, "Solid")}
    assert filled == (
        {"together": set(), "alone": set()} if contacts else {"together": modes[OVERLAID], "alone": modes["Solid"]}
    )
    said = [name for chunk in Read(path).chunks["/world/mujoco/tuned/sphere"] for name in chunk.schema.names]
    assert ("Ellipsoids3D:fill_mode" in said) == contacts


def test_plots_hold_what_the_states_say(folder: Folder) -> None:
    scene = Scene(bodies=(Body(name="ball", mass=2.0, inertia=((1.5, 0, 0), (0, 2, 0.5), (0, 0.5, 2.5)), q_WB=QUARTER),))
    actual = rising(scene, 3.0)
    actual.w_WB[:] = [2.0, 0.0, 1.0]
    folder.add(record("rise", "mujoco"), scene, actual, rising(scene))
    read = Read(folder.write()[0])
    # m v^2/2 = 9 J; turned by a quarter about z, the world's x is the body's -y: w = (0, -2, 1) in the body, and
    # w I w/2 = (2 * 4 - 2 * 0.5 * 2 * 1 + 2.5 * 1) / 2 = 4.25 J.
    # The run's, then the truth's.
    assert read.column("/metrics/speed/together", "SeriesLines:names") == [["mujoco tuned", "truth"]]
    assert read.array("/metrics/kinetic_energy/together", "Scalars:scalars")[:, 0] == pytest.approx(np.full(11, 13.25))
    assert read.array("/metrics/speed/together", "Scalars:scalars") == pytest.approx(np.tile([3.0, 1.0], (11, 1)))
    error = read.array("/metrics/position_error/mujoco/tuned", "Scalars:scalars")
    assert error[:, 0] == pytest.approx(2.0 * TIMES, abs=1e-12)


def test_curves_through_the_same_instants_share_rows_and_others_stand_by_themselves(folder: Folder) -> None:
    scene = zoo()
    for engine, speed in (("mujoco", 1.0), ("bullet", 2.0), ("dart", 3.0)):
        actual = rising(scene, speed)
        if engine == "dart":
            # It diverges on its way.
            actual.p_WB[6:] = np.nan
        folder.add(record("rise", engine), scene, actual)
    read = Read(folder.write()[0])
    assert read.column("/metrics/speed/together", "SeriesLines:names") == [["bullet tuned", "mujoco tuned"]]
    assert read.array("/metrics/speed/together", "Scalars:scalars") == pytest.approx(np.tile([2.0, 1.0], (11, 1)))
    assert read.array("/metrics/speed/dart/tuned", "Scalars:scalars") == pytest.approx(np.full((6, 1), 3.0))
    engines = [int(ENGINES[name].colour[1:] + "ff", 16) for name in ("bullet", "mujoco")]
    assert read.column("/metrics/speed/together", "SeriesLines:colors") == [engines]


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
    assert "/world/bullet/tuned/sphere" in read.chunks
    assert "/world/mujoco/tuned/sphere" not in read.chunks


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


def test_an_inertial_signal_of_more_readings_than_frames_keeps_every_peak_and_dip_of_each_axis(folder: Folder) -> None:
    scene, actual = sensing()
    signal = np.random.default_rng(2).normal(size=(10_000, 3))
    for axis in range(3):
        signal[2000 + 777 * axis, axis], signal[7000 + 777 * axis, axis] = 50.0 + axis, -60.0 - axis
    streams = {"imu/time": np.linspace(0.0, TIMES[-1], len(signal)), "imu/accelerometer": signal, "imu/gyroscope": -signal}
    folder.add(record("sense", "mujoco"), scene, dataclasses.replace(actual, streams=streams))
    read = Read(folder.write()[0])
    shown = read.array("/sensors/imu/accelerometer/mujoco/tuned", "Scalars:scalars")
    assert shown.max(axis=0) == pytest.approx([50.0, 51.0, 52.0])
    assert shown.min(axis=0) == pytest.approx([-60.0, -61.0, -62.0])
    # A tenth of a second plays for 6 s of 60 frames: stretches of 27 readings, and in two of them six extremes at most.
    assert 2 * 360 <= len(shown) <= 3 * 10_000 / 27 + 56
    seconds = np.array([stamp.total_seconds() for stamp in read.column("/sensors/imu/accelerometer/mujoco/tuned", "sim_time")])
    nearest = np.abs(streams["imu/time"] - seconds[:, None]).argmin(axis=1)
    assert shown == pytest.approx(signal[nearest])


def test_a_scan_is_a_cloud_where_its_beams_ended_in_the_world(folder: Folder) -> None:
    scene, actual = sensing()
    folder.add(record("sense", "mujoco"), scene, actual)
    read = Read(folder.write()[0])
    clouds = read.column("/sensors/lidar/points/mujoco/tuned", "Points3D:positions")
    # Beams along +x, +y, -x, -y of the carrier, which a quarter turn about z lays along +y, -x, -y, +x; the third saw nothing.
    expected = [[1.0, 4.0, 3.0], [-2.0, 2.0, 3.0], [5.0, 2.0, 3.0]]
    assert np.array(clouds) == pytest.approx(np.array([expected, expected]), abs=1e-6)


def test_a_second_writing_gives_the_same_content(folder: Folder) -> None:
    """In which order the writer's batches of one path come is its own affair."""

    def content(read: Read) -> dict[str, list[str]]:
        plain = {where: [batch.drop_columns(["rerun.controls.RowId"]) for batch in read.chunks[where]] for where in read.chunks}
        return {where: sorted(repr(batch.to_pydict()) for batch in batches) for where, batches in plain.items()}

    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()), rising(zoo()))
    path = folder.write()[0]
    first = Read(path)
    write_recordings(folder.path)
    again = Read(path)
    assert again.store.summary() == first.store.summary()
    assert content(again) == content(first)


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
    assert angle_between(quarter, np.array([1.0, 0, 0, 0])) == pytest.approx(np.pi / 2)
    assert angle_between(quarter, -quarter) == pytest.approx(0.0)


@pytest.mark.parametrize("sides", [(1, 1, 1), (5, 1, 1), (1, 60, 1), (60, 1, 1), (1, 1, 20)])
def test_the_eye_lies_outside_of_what_it_looks_at(sides: tuple[float, float, float]) -> None:
    half = np.array(sides) / 2.0
    frame = framed(-half, half)
    assert (np.abs(frame.eye) > half).any()
    assert frame.eye[2] > frame.target[2]
    assert (np.abs(frame.target) <= half + 1e-9).all()
