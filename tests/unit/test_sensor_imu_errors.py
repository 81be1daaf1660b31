"""Errors of inertial channels: axes out of line, scale, bounds, digits, latency, and who is asked for the signal."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline.harness.scene import AxisNoise, Body, Imu, ImuNoise, Scene
from plumbline.harness.sensors.imu import read_out, sensed
from plumbline.harness.sensors.recorder import SensorRecorder, steps_of_latency
from plumbline.harness.trajectory import Floats, State

BODY = Body(name="b")
SENSOR = Imu(name="imu", body="b", rate=100.0)


class Ramp:
    """A simulation whose body speeds up by x'' = 2 t and turns at w = 3 t, with a sensor of its own if it is given one."""

    def __init__(self, dt: float) -> None:
        self.dt, self.steps = dt, 0

    def step(self, count: int = 1) -> None:
        self.steps += count

    def state(self, out: State) -> None:
        t = self.steps * self.dt
        out.v_WB[:], out.w_WB[:] = (t * t, 0, 0), (3 * t, 0, 0)
        angle = 1.5 * t * t
        out.q_WB[:] = (np.cos(angle / 2), np.sin(angle / 2), 0, 0)


class Native(Ramp):
    """The same with an accelerometer and a gyroscope."""

    def inertial(self, name: str) -> tuple[Floats, Floats]:
        assert name == "imu"
        t = self.steps * self.dt
        return np.array([2 * t, 0, 0]), np.array([3 * t, 0, 0])


def _record(simulation: Any, sensor: Imu, steps: int = 40, seed: int = 1) -> dict[str, Floats]:
    scene = Scene(bodies=(BODY,), sensors=(sensor,), gravity=(0, 0, 0))
    recorder = SensorRecorder(scene, simulation, seed, simulation.dt)
    state = State.initial(scene)
    recorder.read(0.0, state)
    while simulation.steps < steps:
        simulation.step(recorder.interval_steps)
        simulation.state(state)
        recorder.read(simulation.steps * simulation.dt, state)
    return recorder.streams()


def test_a_triad_out_of_line_reads_the_signal_in_its_own_axes() -> None:
    law = AxisNoise(misalignment=(0.2, -0.1, 0.3), scale_error=0.05)
    signal = np.random.default_rng(1).normal(size=(50, 3))
    expected = 1.05 * Rotation.from_rotvec(law.misalignment).inv().apply(signal)
    np.testing.assert_allclose(sensed(law, signal), expected, atol=1e-15)
    np.testing.assert_array_equal(sensed(AxisNoise(), signal), signal)


def test_a_triad_turned_by_a_right_angle_about_z_reads_x_as_minus_y() -> None:
    found = sensed(AxisNoise(misalignment=(0, 0, np.pi / 2)), np.array([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(found, [[0, -1, 0]], atol=1e-15)


def test_readings_are_whole_steps_within_the_bounds_and_what_is_not_a_number_stays_none() -> None:
    law = AxisNoise(saturation=1.0, quantisation=0.3)
    found = read_out(law, np.array([0.14, 0.16, -0.46, 0.95, 7.0, -np.inf, np.nan]))
    np.testing.assert_allclose(found, [0.0, 0.3, -0.6, 0.9, 0.9, -0.9, np.nan], atol=1e-15)
    # 16 g in steps of 16 g/2^15: the bound itself is a step, whatever the rounding of the two.
    full = 16 * 9.80665
    assert read_out(AxisNoise(saturation=full, quantisation=full / 2**15), np.array([1e9]))[0] == pytest.approx(full, rel=1e-12)


def test_rounding_adds_the_variance_of_a_uniform_error() -> None:
    noise = np.random.default_rng(2).normal(size=200_000)
    rest = read_out(AxisNoise(quantisation=0.5), noise) - noise
    assert np.abs(rest).max() <= 0.25
    # The variance of a uniform variable's square is 4/5 of the square of its mean: five deviations over 200 000.
    assert rest.var() == pytest.approx(0.25 / 12, rel=5 * np.sqrt(0.8 / 200_000))


def test_errors_come_in_the_order_that_the_scene_says() -> None:
    law = AxisNoise(scale_error=0.5, bias=0.2, saturation=1.0, quantisation=0.25)
    streams = _record(Ramp(0.01), replace(SENSOR, noise=ImuNoise(accelerometer=law)))
    ideal = streams["imu/accelerometer_ideal"]
    np.testing.assert_allclose(
        streams["imu/accelerometer"], np.clip(0.25 * np.rint((1.5 * ideal + 0.2) / 0.25), -1, 1), atol=1e-15
    )
    assert streams["imu/accelerometer"].max() == 1.0


@pytest.mark.parametrize("late", [1, 2, 3, 4, 6, 9])
def test_a_reading_tells_of_the_instant_before_its_latency(late: int) -> None:
    """Two steps an interval: latencies that are whole intervals and that are not."""
    dt = 0.005
    streams = _record(Ramp(dt), replace(SENSOR, latency=late * dt))
    stamps = streams["imu/time"]
    first = (1 + -(-late // 2)) * 0.01
    np.testing.assert_allclose(stamps, np.arange(first, 0.2 + 1e-9, 0.01), atol=1e-14)
    np.testing.assert_allclose(streams["imu/gyroscope"][:, 0], 3 * (stamps - late * dt), atol=1e-13)
    # A quadratic velocity's difference is its slope in the middle of the interval.
    np.testing.assert_allclose(streams["imu/accelerometer"][:, 0], 2 * (stamps - late * dt - 0.005), atol=1e-12)
    assert {len(signal) for signal in streams.values()} == {len(stamps)}


def test_a_latency_of_no_whole_steps_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"sensor 'imu': latency 0\.007 s, expected a whole number of steps of 0\.005 s"):
        steps_of_latency(replace(SENSOR, latency=0.007), 0.005)
    with pytest.raises(ValueError, match="latency"):
        _record(Ramp(0.005), replace(SENSOR, latency=0.0024))


def test_an_engines_own_sensor_is_asked_only_where_it_is_wanted_and_there() -> None:
    own = _record(Native(0.005), SENSOR)
    np.testing.assert_allclose(own["imu/accelerometer"][:, 0], 2 * own["imu/time"], atol=1e-15)
    np.testing.assert_array_equal(own["imu/native"], np.ones(20))
    for simulation, sensor in ((Native(0.005), replace(SENSOR, reading="states")), (Ramp(0.005), SENSOR)):
        states = _record(simulation, sensor)
        np.testing.assert_allclose(states["imu/accelerometer"][:, 0], 2 * (states["imu/time"] - 0.005), atol=1e-12)
        np.testing.assert_array_equal(states["imu/native"], np.zeros(20))
        np.testing.assert_array_equal(states["imu/time"], own["imu/time"])


def test_the_same_seed_repeats_bit_by_bit_another_does_not_and_a_longer_run_begins_with_the_shorter() -> None:
    law = AxisNoise(density=1e-3, instability=1e-3, random_walk=1e-3)
    sensor = replace(SENSOR, noise=ImuNoise(accelerometer=law, gyroscope=law))
    first, again, other = (_record(Ramp(0.005), sensor, seed=seed) for seed in (1, 1, 2))
    long = _record(Ramp(0.005), sensor, steps=80)
    for channel in ("imu/accelerometer", "imu/gyroscope"):
        assert first[channel].tobytes() == again[channel].tobytes()
        assert not np.any(first[channel] == other[channel])
        assert long[channel][:20].tobytes() == first[channel].tobytes()
