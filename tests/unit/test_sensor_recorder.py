"""Recorder: rates, time stamps and signals on motions known in closed form, played back through the engine's interface."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import Body, Box, Camera, Effect, Imu, Lidar, PlacedShape, Plane, Scene, Sphere, axis_angle
from plumbline.harness.sensors import lidar as scanning
from plumbline.harness.sensors import recorder
from plumbline.harness.sensors.lidar import LidarReader
from plumbline.harness.sensors.rays import first_hits
from plumbline.harness.sensors.recorder import SensorRecorder
from plumbline.harness.trajectory import Floats, Hits, Image, State, Trajectory


class Playback:
    """A simulation whose states are those of a given motion, with rays in closed form."""

    def __init__(self, scene: Scene, motion: Any, dt: float) -> None:
        self.scene, self.motion, self.dt, self.steps = scene, motion, dt, 0

    def step(self, count: int = 1) -> None:
        self.steps += count

    def state(self, out: State) -> None:
        for name, value in self.motion(self.steps * self.dt).items():
            getattr(out, name)[:] = value

    def cast(self, origins: Floats, directions: Floats, max_range: float) -> Hits:
        state = State.initial(self.scene)
        self.state(state)
        return first_hits(self.scene, state, origins, directions, max_range)

    def render(self, camera: Camera, colour: bool = True) -> Image:
        raise Unsupported(f"image of camera '{camera.name}'", "a played motion has no picture")


def _record(scene: Scene, motion: Any, dt: float, steps: int, at_start: bool = True) -> dict[str, Floats]:
    simulation = Playback(scene, motion, dt)
    recorder = SensorRecorder(scene, simulation, 1, dt)  # type: ignore[arg-type]
    state = State.initial(scene)
    if at_start:
        recorder.read(0.0, state)
    while simulation.steps < steps:
        simulation.step(recorder.interval_steps)
        simulation.state(state)
        recorder.read(simulation.steps * dt, state)
    return recorder.streams()


def _still(_t: float) -> dict[str, Any]:
    return {}


BODY = Body(name="b")
SENSOR = Imu(name="imu", body="b", rate=100.0)


def test_at_rest_an_accelerometer_reads_gravity_upwards_in_its_own_frame() -> None:
    turned = replace(SENSOR, q_BS=axis_angle((1, 0, 0), np.pi / 2))
    streams = _record(Scene(bodies=(BODY,), sensors=(turned,)), _still, 0.005, 20)
    # S's y axis is W's z axis.
    np.testing.assert_allclose(streams["imu/accelerometer"], np.tile([0, 9.81, 0], (10, 1)), atol=1e-14)
    np.testing.assert_array_equal(streams["imu/gyroscope"], np.zeros((10, 3)))


def test_in_free_fall_it_reads_nothing() -> None:
    streams = _record(Scene(bodies=(BODY,), sensors=(SENSOR,)), lambda t: {"v_WB": (1, 0, -9.81 * t)}, 0.01, 10)
    np.testing.assert_allclose(streams["imu/accelerometer"], 0.0, atol=1e-12)


def test_a_scene_whose_gravity_is_switched_off_has_none_to_feel() -> None:
    scene = Scene(bodies=(BODY,), sensors=(SENSOR,), narrow=Effect.GRAVITY)
    np.testing.assert_array_equal(_record(scene, _still, 0.01, 5)["imu/accelerometer"], np.zeros((5, 3)))


def test_on_a_turntable_it_reads_centripetal_and_tangential_force_at_its_lever() -> None:
    """w = a t about z: w^2 r inwards and a r along the circle, at the middle of each interval."""
    angular, r = 3.0, 0.4
    scene = Scene(bodies=(BODY,), sensors=(replace(SENSOR, p_BS=(r, 0, 0), rate=1000.0),), gravity=(0, 0, 0))

    def motion(t: float) -> dict[str, Any]:
        angle = 0.5 * angular * t * t
        return {"q_WB": (np.cos(angle / 2), 0, 0, np.sin(angle / 2)), "w_WB": (0, 0, angular * t)}

    streams = _record(scene, motion, 0.001, 500)
    middle = streams["imu/time"] - 0.0005
    # The chord of a smooth curve over T errs by T^2/24 times its third derivative; w <= 1.5 rad/s makes that below 1e-6.
    np.testing.assert_allclose(streams["imu/accelerometer"][:, 0], -((angular * middle) ** 2) * r, atol=1e-6)
    np.testing.assert_allclose(streams["imu/accelerometer"][:, 1], angular * r, atol=1e-6)
    np.testing.assert_allclose(streams["imu/gyroscope"][:, 2], angular * streams["imu/time"], atol=1e-12)


def test_readings_lag_half_an_interval_and_stand_at_exact_times() -> None:
    scene = Scene(bodies=(BODY,), sensors=(SENSOR,), gravity=(0, 0, 0))
    streams = _record(scene, lambda t: {"v_WB": (t * t, 0, 0)}, 0.0025, 40)
    np.testing.assert_allclose(streams["imu/time"], np.arange(1, 11) * 0.01, rtol=0, atol=1e-15)
    # a = 2 t at the middle of each interval, exactly for a quadratic.
    np.testing.assert_allclose(streams["imu/accelerometer"][:, 0], 2 * (streams["imu/time"] - 0.005), atol=1e-13)


def test_angular_velocity_is_given_in_the_frame_of_the_sensor() -> None:
    q_WB, q_BS = axis_angle((1, 2, 3), 0.8), axis_angle((0, 1, 0), 0.3)
    scene = Scene(bodies=(BODY,), sensors=(replace(SENSOR, q_BS=q_BS),))
    streams = _record(scene, lambda _t: {"q_WB": q_WB, "w_WB": (0.1, 0.2, 0.3)}, 0.01, 2)
    from plumbline.harness.scene import multiply, rotation_matrix

    expected = np.array(rotation_matrix(multiply(q_WB, q_BS))).T @ (0.1, 0.2, 0.3)
    np.testing.assert_allclose(streams["imu/gyroscope"][0], expected, atol=1e-15)


def test_sensors_of_several_rates_are_each_read_at_their_own() -> None:
    sensors = (SENSOR, replace(SENSOR, name="slow", rate=40.0), Lidar(name="eye", body="b", rate=20.0, channels=1, columns=4))
    ground = Body(name="g", motion="static", collision=(PlacedShape(shape=Plane()),), p_WB=(0, 0, -1))
    scene = Scene(bodies=(BODY, ground), sensors=sensors)
    dt = 0.0025
    assert SensorRecorder(scene, Playback(scene, _still, dt), 1, dt).interval_steps == 2  # type: ignore[arg-type]
    streams = _record(scene, _still, dt, 80)
    assert len(streams["imu/time"]) == 20
    np.testing.assert_allclose(streams["slow/time"], np.arange(1, 9) * 0.025, atol=1e-15)
    np.testing.assert_allclose(streams["eye/time"], np.arange(5) * 0.05, atol=1e-15)
    assert len(_record(scene, _still, dt, 80, at_start=False)["eye/time"]) == 4


def test_streams_are_cut_by_their_own_time_stamps() -> None:
    scene = Scene(bodies=(BODY,), sensors=(SENSOR,))
    whole = replace(Trajectory.of(np.linspace(0, 0.2, 3), 1), streams=_record(scene, _still, 0.01, 20))
    part = whole.between(0.05, 0.1)
    np.testing.assert_allclose(part.streams["imu/time"], np.arange(5, 11) * 0.01, atol=1e-15)
    assert {len(s) for s in part.streams.values()} == {6}


@pytest.mark.parametrize("rate", [70.0, 1000.0])
def test_a_rate_that_the_step_does_not_divide_is_refused_by_name(rate: float) -> None:
    scene = Scene(bodies=(BODY,), sensors=(replace(SENSOR, rate=rate),))
    with pytest.raises(ValueError, match=rf"sensor 'imu': rate {rate:g} Hz"):
        SensorRecorder(scene, Playback(scene, _still, 0.004), 1, 0.004)  # type: ignore[arg-type]


def test_a_camera_that_the_engine_cannot_draw_for_is_refused_and_not_ignored() -> None:
    scene = Scene(bodies=(BODY,), sensors=(Camera(name="eye", body="b", rate=100.0),))
    with pytest.raises(Unsupported, match="eye"):
        _record(scene, _still, 0.01, 1)


def test_a_sensor_that_nothing_reads_is_refused_and_not_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "READERS", {"lidar": LidarReader})
    scene = Scene(bodies=(BODY,), sensors=(SENSOR,))
    with pytest.raises(Unsupported, match=r"sensor 'imu': no recorder reads a imu"):
        SensorRecorder(scene, Playback(scene, _still, 0.01), 1, 0.01)  # type: ignore[arg-type]


def test_beams_cover_the_pattern_counter_clockwise_from_x() -> None:
    found = scanning.beams(Lidar(name="l", body="b", rate=1.0, channels=3, columns=4, elevation_low=-0.5, elevation_high=0.5))
    np.testing.assert_allclose(found[1], [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], atol=1e-15)
    np.testing.assert_allclose(found[2, 0], [np.cos(0.5), 0, np.sin(0.5)], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1.0, atol=1e-15)


def test_a_range_finder_sees_from_where_it_is_mounted_on_a_moving_body() -> None:
    wall = Body(name="wall", motion="static", collision=(PlacedShape(shape=Box(half_extents=(0.5, 9, 9))),), p_WB=(10, 0, 0))
    ball = Body(name="ball", motion="static", collision=(PlacedShape(shape=Sphere(radius=1.0)),), p_WB=(0, 5, 0))
    lidar = Lidar(
        name="l", body="b", rate=10.0, p_BS=(0, 1, 0), q_BS=axis_angle((0, 0, 1), np.pi / 2), max_range=9.0,
        channels=1, columns=4, elevation_low=0.0, elevation_high=0.0,
    )  # fmt: skip
    scene = Scene(bodies=(BODY, wall, ball), sensors=(lidar,))

    def motion(t: float) -> dict[str, Any]:
        state = State.initial(scene)
        state.p_WB[0] = (t, 0.0, 0.0)
        # Turned by -90 degrees: S's x axis is W's x axis again, and the mount (0, 1, 0) in B lies at +x.
        state.q_WB[0] = axis_angle((0, 0, 1), -np.pi / 2)
        return {"p_WB": state.p_WB, "q_WB": state.q_WB}

    streams = _record(scene, motion, 0.1, 10, at_start=False)
    x = 1.0 + streams["l/time"]
    expected = np.where(9.5 - x <= 9.0, 9.5 - x, np.inf)
    np.testing.assert_allclose(streams["l/range"][:, 0, 0], expected, atol=1e-14)
    # At x = 1 + t > 1 the beam to +y passes the ball; the wall is met head-on.
    assert np.isinf(streams["l/range"][:, 0, 1]).all()
    np.testing.assert_allclose(streams["l/intensity"][:, 0, 0], 1.0, atol=1e-14)
    assert (streams["l/intensity"][:, 0, 1:] == 0.0).all()
