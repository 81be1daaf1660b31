"""Sensors on a robot: on which body they come to stand, what of MJCF is carried over, and what ideal readings are judged by."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.case.scene_file import own_case
from plumbline.harness.intake.error import RobotError
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.readings import gyroscope_off_motion, range_off_geometry
from plumbline.harness.scene import (
    Body,
    Box,
    Camera,
    Imu,
    Lidar,
    PlacedShape,
    Plane,
    Scene,
    Surface,
    axis_angle,
    box_inertia,
    rotate,
    rotation_matrix,
)
from plumbline.harness.scene.file import dump_toml
from plumbline.harness.scene.importers.companion import Cameras, Companion
from plumbline.harness.scene.importers.fidelity import Imported
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trial.answer import answer_of
from tests.robot_files import INERTIAL, imported, mjcf, row, urdf

pytestmark = pytest.mark.usefixtures("mjcf_here")
ANGLES = (0.4, 0.5, 0.6)
TOOL = (
    f'<link name="tool">{INERTIAL}</link><joint name="bolt" type="fixed"><parent link="arm"/><child link="tool"/>'
    '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/></joint>'
)


def stands(got: Imported, place: int) -> tuple[object, object]:
    """Where a sensor stands in W at the start: place [m] and rotation."""
    sensor = got.scene.sensors[place]
    body = got.scene.body(sensor.body)
    R = np.array(rotation_matrix(body.q_WB))
    return np.array(body.p_WB) + R @ np.array(sensor.p_BS), R @ np.array(rotation_matrix(sensor.q_BS))


def test_a_sensor_on_a_link_that_is_merged_stands_where_the_link_does(tmp_path: Path) -> None:
    """The joint is at (0, 0, 1); the bolt's roll, pitch and yaw turn about fixed axes."""
    turned = axis_angle((0.0, 0.0, 1.0), 0.7)
    unit = Imu(name="unit", body="tool", rate=240.0, p_BS=(0.01, 0.02, 0.03), q_BS=turned)
    got = imported(tmp_path, urdf(TOOL, base=INERTIAL), Companion(root="fixed", sensors=(unit,)))
    assert got.scene.sensors[0].body == "arm"
    x, y, z = (
        np.array(rotation_matrix(axis_angle(axis, angle))) for axis, angle in zip(np.eye(3).tolist(), ANGLES, strict=True)
    )
    R = z @ y @ x
    where, how = stands(got, 0)
    assert where == pytest.approx(np.array([0.1, 0.2, 1.3]) + R @ [0.01, 0.02, 0.03], abs=1e-14)
    assert how == pytest.approx(R @ np.array(rotation_matrix(turned)), abs=1e-14)


def test_a_sensor_on_no_link_is_refused(tmp_path: Path) -> None:
    unit = Imu(name="unit", body="head", rate=240.0)
    with pytest.raises(RobotError, match="sensor 'unit': body 'head' is no link of the robot, expected one of 'base', 'arm'"):
        imported(tmp_path, urdf(), Companion(root="fixed", sensors=(unit,)))
    with pytest.raises(RobotError, match="'unit' stands twice"):
        imported(tmp_path, urdf(), Companion(root="fixed", sensors=(replace(unit, body="arm"),) * 2))


def test_sensors_of_mjcf_are_carried_over_or_told(tmp_path: Path) -> None:
    body = '<joint name="j"/><geom size=".1" mass="1"/><site name="s" pos=".1 .2 .3" euler="0 90 0"/>'
    sensors = (
        '<sensor><accelerometer name="a" site="s"/><gyro site="s"/><rangefinder name="r" site="s" cutoff="5"/>'
        '<jointpos name="p" joint="j"/></sensor>'
    )
    got = imported(tmp_path, mjcf(body, sensors))
    unit, finder = sorted(got.scene.sensors, key=lambda one: one.type)
    assert isinstance(unit, Imu)
    assert isinstance(finder, Lidar)
    assert (unit.name, finder.name, finder.max_range) == ("a", "r", 5.0)
    for place in range(2):
        assert stands(got, place)[0] == pytest.approx([0.1, 0.2, 1.3], abs=1e-12)
    # MuJoCo's beam goes along the site's z, which the pitch of 90 degrees has laid along x of W; ours along x of the sensor.
    finds = next(k for k, one in enumerate(got.scene.sensors) if one.type == "lidar")
    assert np.array(stands(got, finds)[1])[:, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert row(got, "sensor jointpos").outcome == "left_out"


def drone() -> Scene:
    """A box that turns in free fall above a plane, with a unit and a range finder that looks all around."""
    half = (0.1, 0.2, 0.05)
    box = Body(
        name="box",
        inertia=box_inertia(1.0, half),
        collision=(PlacedShape(shape=Box(half_extents=half)),),
        p_WB=(0.0, 0.0, 2.0),
        w_WB=(0.5, -1.0, 2.0),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    unit = Imu(name="unit", body="box", rate=240.0, q_BS=axis_angle((1.0, 0.0, 0.0), 0.3))
    finder = Lidar(name="finder", body="box", rate=60.0, p_BS=(0.0, 0.0, 0.2), channels=8, columns=16)
    return Scene(bodies=(ground, box), surfaces=(Surface(),), sensors=(unit, finder))


def run_of(tmp_path: Path) -> tuple[Scene, Trajectory]:
    path = tmp_path / "drone.toml"
    path.write_text(dump_toml(drone()))
    (tmp_path / "drone.plumb.toml").write_text("duration = 0.2\n")
    case, adapter = own_case(path, plugins.SCENE_PREFIX), plugins.adapter("mujoco")
    trial = Trial(
        study="s",
        experiment=Experiment(name="e"),
        case=case.name,
        parameters={},
        engine="mujoco",
        engine_version="0",
        track="tuned",
        settings=adapter.tracks["tuned"].with_dt(1 / 240),
        seed=0,
    )
    scene = case.scene(case.parameters)
    return scene, answer_of(trial, trial.problem(case), adapter).actual


def test_ideal_readings_are_judged_by_the_motion_that_they_ride_on(tmp_path: Path) -> None:
    """In double precision both are rounding: rates of 2 rad/s in 1e-12, ranges of metres in 1e-9; planted faults are seen."""
    scene, run = run_of(tmp_path)
    assert gyroscope_off_motion(scene, run, None) < 1e-12
    assert range_off_geometry(scene, run, None) < 1e-9
    told = ~np.isnan(run.streams["unit/gyroscope_due"]).any(axis=1)
    assert told.sum() == len(run) - 1
    wrong = dict(run.streams)
    wrong["unit/gyroscope_ideal"] = run.streams["unit/gyroscope_ideal"] + [0.0, 0.0, 0.01]
    wrong["finder/range_ideal"] = run.streams["finder/range_ideal"] + 0.002
    faulty = replace(run, streams=wrong)
    assert gyroscope_off_motion(scene, faulty, None) == pytest.approx(0.01, rel=1e-6)
    assert range_off_geometry(scene, faulty, None) == pytest.approx(0.002, rel=1e-3)
    wrong["finder/range_ideal"] = np.full_like(run.streams["finder/range_ideal"], np.nan)
    assert np.isnan(range_off_geometry(scene, replace(run, streams=wrong), None))
    with pytest.raises(NotMeasurable):
        range_off_geometry(scene, replace(run, streams={}), None)


def test_a_rate_that_no_step_meets_is_refused_before_anything_runs(tmp_path: Path) -> None:
    path = tmp_path / "drone.toml"
    path.write_text(dump_toml(drone()))
    (tmp_path / "drone.plumb.toml").write_text("dt = 0.01\n")
    with pytest.raises(RobotError, match="sensor 'unit': rate 240 Hz, expected a whole divisor of the 100 steps"):
        own_case(path, plugins.SCENE_PREFIX)


def test_a_step_of_ones_own_is_halved_like_the_usual_one_and_sampled_at_common_instants(tmp_path: Path) -> None:
    path = tmp_path / "ball.toml"
    path.write_text(dump_toml(Scene(bodies=(Body(name="b"),))))
    (tmp_path / "ball.plumb.toml").write_text("dt = 0.003\nduration = 1.5\n")
    case = own_case(path, plugins.SCENE_PREFIX)
    assert case.ladder == pytest.approx((0.003, 0.0015, 0.00075), rel=1e-15)
    assert (case.dt, case.duration) == (0.003, 1.5)
    for step in case.ladder:
        assert case.sample_interval / step == pytest.approx(round(case.sample_interval / step), abs=1e-9)


CAMERAS = (
    '<joint name="j" axis="0 1 0"/><geom size=".1"/><camera name="ahead" pos=".1 0 0" xyaxes="0 -1 0 0 0 1" fovy="90"/>'
    '<camera name="chase" mode="track" pos="-1 0 0"/>'
)


def test_cameras_of_mjcf_that_ride_on_a_body_are_pinholes_where_their_pictures_are_asked_for(tmp_path: Path) -> None:
    plain = imported(tmp_path, mjcf(CAMERAS))
    assert plain.scene.sensors == ()
    assert (row(plain, "camera").count, row(plain, "camera").outcome) == (2, "left_out")
    got = imported(tmp_path, mjcf(CAMERAS), Companion(cameras=Cameras(rate=20.0, width=80, height=60)))
    (camera,) = got.scene.sensors
    assert isinstance(camera, Camera)
    assert (camera.name, camera.body, camera.rate, camera.width, camera.height) == ("ahead", "arm", 20.0, 80, 60)
    # Half the height is seen under 45 degrees: one focal length.
    assert camera.focal_y == pytest.approx(30.0)
    # The file's x points to -y and its y up, so that it looks along x: ours has z ahead, x right and y down.
    ahead, right, down = (rotate(camera.q_BS, axis) for axis in ((0, 0, 1), (1, 0, 0), (0, 1, 0)))
    assert np.allclose([ahead, right, down], [[1, 0, 0], [0, -1, 0], [0, 0, -1]], atol=1e-12)
    assert camera.p_BS == pytest.approx((0.1, 0.0, 0.0))
    assert {each.outcome for each in got.fidelity if each.element == "camera"} == {"approximated", "left_out"}
    stated = mjcf(CAMERAS.replace('fovy="90"', 'fovy="90" resolution="320 200"'))
    (own,) = imported(tmp_path, stated, Companion(cameras=Cameras())).scene.sensors
    assert (own.width, own.height, own.centre_x) == (320, 200, 160.0)  # type: ignore[union-attr]
