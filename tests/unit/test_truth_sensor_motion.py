"""Truths of moving sensors against independent routes, and the premises of their cases' bounds."""

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from plumbline.cases import (
    sensor_imu_free_fall,
    sensor_imu_integral,
    sensor_imu_lag,
    sensor_imu_rest,
    sensor_imu_turntable,
    sensor_lidar_polyhedra,
    sensor_lidar_room,
    sensor_lidar_shapes,
    sensor_streams,
)
from plumbline.cases.sensor_imu_turntable import DURATION, LEVER, MOUNTING, RATE, SPIN_UP, G
from plumbline.harness.case import Case
from plumbline.harness.metrics.readings import (
    accelerometer_ideal_error,
    accelerometer_lag_error,
    gyroscope_ideal_error,
    gyroscope_lag_error,
)
from plumbline.harness.scene import Lidar, Scene, rotation_matrix
from plumbline.harness.sensors import lidar as scanning
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.recorder import SensorRecorder, steps_between_readings, steps_of_latency
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import rotate

TURNTABLE = sensor_imu_turntable.CASE
CASES = [
    module.CASE
    for module in (
        sensor_imu_free_fall,
        sensor_imu_integral,
        sensor_imu_lag,
        sensor_imu_rest,
        sensor_imu_turntable,
        sensor_lidar_polyhedra,
        sensor_lidar_room,
        sensor_lidar_shapes,
        sensor_streams,
    )
]


def _truth(case: Case, time: Floats) -> Trajectory:
    truth = case.truth_at(time, case.parameters)
    assert isinstance(truth, Trajectory)
    return truth


class Told:
    """A simulation whose states are a case's truth."""

    def __init__(self, case: Case, dt: float) -> None:
        self.case, self.dt, self.steps = case, dt, 0

    def state(self, out: State) -> None:
        truth = _truth(self.case, np.array([self.steps * self.dt]))
        out.p_WB[:], out.q_WB[:], out.v_WB[:], out.w_WB[:] = truth.p_WB[0], truth.q_WB[0], truth.v_WB[0], truth.w_WB[0]


def _read(case: Case, dt: float, duration: float) -> tuple[Scene, Trajectory, Trajectory]:
    """The scene, what its sensors say of the true motion, and the truth."""
    scene = case.scene(case.parameters)
    told: Any = Told(case, dt)
    recorder = SensorRecorder(scene, told, 1, dt)
    state = State.empty(len(scene.bodies))
    while told.steps <= round(duration / dt):
        told.state(state)
        recorder.read(told.steps * dt, state)
        told.steps += recorder.interval_steps
    time = np.array([0.0, duration])
    return scene, replace(_truth(case, time), streams=recorder.streams()), _truth(case, time)


@pytest.mark.parametrize("case", [TURNTABLE, sensor_imu_free_fall.CASE, sensor_imu_rest.CASE], ids=lambda case: case.name)
def test_a_sensor_that_is_told_the_true_motion_reads_the_closed_form(case: Case) -> None:
    answer = _read(case, case.dt, case.duration)
    assert accelerometer_ideal_error(*answer) < 1e-9
    assert gyroscope_ideal_error(*answer) < 1e-9


def test_the_turntables_mean_force_is_its_integral_in_mpmath() -> None:
    """a = w' x r + w x (w x r) in W over one interval, averaged, seen from the attitude in the middle of the two ends."""
    truth, late = _truth(TURNTABLE, np.array([0.0, DURATION])), 1.5
    place = round(late * RATE) - 1
    with mpmath.workdps(30):
        t0, t1 = mpmath.mpf(late) - mpmath.mpf(1) / 60, mpmath.mpf(late)
        angle = lambda t: SPIN_UP * t * t / 2  # noqa: E731 -- one line of algebra
        w = lambda t: SPIN_UP * t  # noqa: E731 -- one line of algebra
        x = lambda t: LEVER * (-(w(t) ** 2) * mpmath.cos(angle(t)) - SPIN_UP * mpmath.sin(angle(t)))  # noqa: E731 -- as above
        y = lambda t: LEVER * (-(w(t) ** 2) * mpmath.sin(angle(t)) + SPIN_UP * mpmath.cos(angle(t)))  # noqa: E731 -- as above
        mean = [mpmath.quad(one, [t0, t1]) / (t1 - t0) for one in (x, y)]
        middle = (angle(t0) + angle(t1)) / 2
        radial = float(mpmath.cos(middle) * mean[0] + mpmath.sin(middle) * mean[1])
        along = float(-mpmath.sin(middle) * mean[0] + mpmath.cos(middle) * mean[1])
    expected = np.array(rotation_matrix(MOUNTING)).T @ [radial, along, G]
    np.testing.assert_allclose(truth.streams["imu/accelerometer_ideal"][place], expected, atol=1e-12)


def test_a_shaken_body_that_moves_as_told_is_seen_without_a_lag_but_what_is_due() -> None:
    answer = _read(sensor_imu_lag.CASE, 1 / 240, 3.0)
    assert accelerometer_lag_error(*answer) < 1e-6
    assert gyroscope_lag_error(*answer) < 1e-6


def test_the_shaken_bodys_states_are_the_integrals_of_what_is_felt() -> None:
    time = np.linspace(0, 3, 6001)
    truth = _truth(sensor_imu_lag.CASE, time)
    for rate, change in ((truth.v_WB, truth.p_WB),):
        np.testing.assert_allclose(np.gradient(change[:, 0, 2], time)[1:-1], rate[1:-1, 0, 2], atol=1e-5)
    pulse = 2 * np.pi * sensor_imu_lag.FREQUENCY
    np.testing.assert_allclose(np.gradient(truth.v_WB[:, 0, 2], time)[1:-1], 3 * np.sin(pulse * time)[1:-1], atol=1e-4)


def test_walls_seen_from_inside_are_the_closed_form_hits_of_the_rooms_bodies() -> None:
    """Another route: the six bodies as boxes that are met from outside."""
    case = sensor_lidar_room.CASE
    scene = case.scene(case.parameters)
    truth = _truth(case, np.array([0.0, 1.0]))
    for name, scan, instant in (("flash", 4, 0.4), ("spinning", 3, 0.4)):
        lidar = next(one for one in scene.sensors if one.name == name)
        assert isinstance(lidar, Lidar)
        state = _truth(case, np.array([instant])).state(0)
        origins, directions = scanning.in_world(lidar, state.p_WB[-1], state.q_WB[-1])
        hits = first_hits(scene, state, origins, directions, 20.0)
        ranges, cosines = scanning.ideal(lidar, scene, directions, hits)
        # The last column of a spinning scan is fired at its stamp.
        columns = slice(None) if name == "flash" else slice(-1, None)
        np.testing.assert_allclose(truth.streams[f"{name}/range_ideal"][scan][:, columns], ranges[:, columns], rtol=1e-13)
        np.testing.assert_allclose(truth.streams[f"{name}/intensity_ideal"][scan][:, columns], cosines[:, columns], rtol=1e-12)


def test_no_beam_of_the_room_grazes_more_than_its_bound_says() -> None:
    truth = _truth(sensor_lidar_room.CASE, np.array([0.0, 1.0]))
    for name in ("flash", "spinning"):
        assert truth.streams[f"{name}/intensity_ideal"].min() > sensor_lidar_room.GRAZING


@pytest.mark.parametrize("module", [sensor_lidar_shapes, sensor_lidar_polyhedra], ids=["shapes", "polyhedra"])
def test_no_beam_grazes_more_than_the_bound_says_and_none_hangs_on_an_edge(module: Any) -> None:
    case = module.CASE
    scene = case.scene(case.parameters)
    lidar, start = scene.sensors[0], State.initial(scene)
    origins, directions = scanning.in_world(lidar, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    hits = first_hits(scene, start, origins, directions, lidar.max_range)
    hit = hits.body >= 0
    assert np.abs(np.sum(hits.normal_W * directions, axis=1))[hit].min() > module.GRAZING
    assert set(hits.body.tolist()) == {-1, *range(len(scene.bodies))}
    rng = np.random.default_rng(1)
    for _ in range(4):
        moved = directions + 1e-6 * rng.uniform(-1, 1, directions.shape)
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
        np.testing.assert_array_equal(first_hits(scene, start, origins, moved, lidar.max_range).body, hits.body)


def test_the_wall_of_the_shapes_lies_partly_beyond_their_sensors_reach() -> None:
    case = sensor_lidar_shapes.CASE
    scene = case.scene(case.parameters)
    origins, directions = scanning.in_world(scene.sensors[0], np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    far = first_hits(scene, State.initial(scene), origins, directions, 100.0)
    wall = far.body == scene.index("wall")
    assert 50 < np.sum(far.distance[wall] > sensor_lidar_shapes.REACH) < wall.sum() - 50


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_step_of_the_ladder_divides_the_sensors_intervals_and_latencies(case: Case) -> None:
    for dt in (case.dt, *case.ladder):
        for sensor in case.scene(case.parameters).sensors:
            assert steps_between_readings(sensor, dt) >= 1
            assert steps_of_latency(sensor, dt) >= 0


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_truth_has_as_many_readings_as_time_stamps(case: Case) -> None:
    if case.expected is None:
        return
    streams = _truth(case, np.linspace(0, case.duration, 4)).streams
    for name, signal in streams.items():
        assert len(signal) == len(streams[name.rsplit("/", 1)[0] + "/time"])


def test_the_lever_of_the_turntable_is_felt_in_the_sensors_frame() -> None:
    """At 1.5 s the middle rate is 4.475 rad/s: 8.0 m/s2 inwards and 1.2 along the circle, by hand."""
    streams = _truth(TURNTABLE, np.array([0.0, DURATION])).streams
    felt = rotate(np.array(MOUNTING), streams["imu/accelerometer_ideal"][round(1.5 * RATE) - 1])
    np.testing.assert_allclose(felt, [-(4.475**2) * 0.4, 1.2, 9.81], atol=0.01)
