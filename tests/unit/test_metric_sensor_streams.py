"""Metrics of lag, spectrum, distribution, stamps and integrated attitude: silent on what is right, loud on planted faults."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbline.cases import sensor_streams
from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.noise_scores import inertial_residual
from plumbline.harness.metrics.inertial_noise import (
    difference_spectrum,
    inertial_correlation_score,
    inertial_distribution_distance,
    inertial_histogram_score,
    inertial_spectrum_score,
)
from plumbline.harness.metrics.readings import (
    accelerometer_lag_error,
    delay,
    gyroscope_attitude_error,
    gyroscope_lag_error,
    time_stamp_error,
)
from plumbline.harness.scene import AxisNoise, Body, Imu, ImuNoise, Lidar, Scene, axis_angle
from plumbline.harness.sensors.imu import read_out, sensed, three_axes
from plumbline.harness.trajectory import Floats, Trajectory

RATE, COUNT = 100.0, 20_000
LAW = AxisNoise(density=2e-3, bias=0.1, random_walk=1e-3, misalignment=(0.02, -0.01, 0.03), scale_error=5e-3)
SLOW = replace(LAW, instability=5e-3, instability_time=0.3)
FALSE_ALARM, FALSE_DISTANCE = 5.0, 2.73
CHANNELS = ("accelerometer", "gyroscope")


def _scene(law: AxisNoise = LAW, **fields: object) -> Scene:
    sensor = Imu(name="imu", body="b", rate=RATE, noise=ImuNoise(accelerometer=law, gyroscope=law))
    return Scene(bodies=(Body(name="b"),), sensors=(replace(sensor, **fields),))  # type: ignore[arg-type]


def _streams(law: AxisNoise, seed: int = 1, name: str = "imu") -> dict[str, Floats]:
    """Noise of a law on a signal that moves by far more than the noise."""
    time = np.arange(1, COUNT + 1) / RATE
    found = {f"{name}/time": time, f"{name}/native": np.zeros(COUNT)}
    ideal = np.stack([3 * np.sin(time), 2 * np.cos(0.7 * time), 9.81 + 0 * time], axis=1)
    for channel in ("accelerometer", "gyroscope"):
        noise = three_axes(law, COUNT, 1 / RATE, seed, name, channel)
        found[f"{name}/{channel}_ideal"] = ideal
        found[f"{name}/{channel}"] = read_out(law, sensed(law, ideal) + noise)
    return found


def _case_streams() -> dict[str, Floats]:
    """What the two sensors of the case say at rest, the late one three readings fewer."""
    found: dict[str, Floats] = {}
    scene = sensor_streams.CASE.scene(sensor_streams.CASE.parameters)
    for sensor in scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        count = round((sensor_streams.DURATION - sensor.latency) * sensor.rate)
        found[f"{sensor.name}/time"] = np.arange(1, count + 1) / sensor.rate + sensor.latency
        for channel in CHANNELS:
            law = getattr(sensor.noise, channel)
            ideal = np.tile((0.0, 0.0, 9.81), (count, 1))
            noise = three_axes(law, count, 1 / sensor.rate, 1, sensor.name, channel)
            found[f"{sensor.name}/{channel}_ideal"] = ideal
            found[f"{sensor.name}/{channel}"] = read_out(law, sensed(law, ideal) + noise)
    return found


def _answer(streams: dict[str, Floats], end: float = COUNT / RATE) -> Trajectory:
    return replace(Trajectory.of(np.array([0.0, end]), 1), streams=streams)


def test_what_axes_out_of_line_and_scale_do_to_the_signal_is_no_noise() -> None:
    rest = inertial_residual(_scene().sensors[0], "gyroscope", Run(_scene(), _answer(_streams(LAW))))  # type: ignore[arg-type]
    noise = three_axes(LAW, COUNT, 1 / RATE, 1, "imu", "gyroscope")
    np.testing.assert_allclose(rest, noise, atol=1e-13)


def test_readings_at_their_bound_or_in_coarse_steps_are_not_judged_as_noise() -> None:
    for change, said in (({"saturation": 3.0}, "cut off at 3"), ({"quantisation": 0.1}, "steps of 0.1")):
        law = replace(LAW, **change)  # type: ignore[arg-type]
        with pytest.raises(NotMeasurable, match=said):
            inertial_spectrum_score(_scene(law), _answer(_streams(law)))


@pytest.mark.parametrize("seeds", [4, pytest.param(12, marks=pytest.mark.slow)])
def test_noise_of_the_law_raises_no_alarm_in_several_seeds(seeds: int) -> None:
    for seed in range(seeds):
        answer = _answer(_streams(LAW, seed))
        assert inertial_spectrum_score(_scene(), answer) < FALSE_ALARM
        assert inertial_histogram_score(_scene(), answer) < FALSE_ALARM
        assert inertial_distribution_distance(_scene(), answer) < FALSE_DISTANCE
        assert inertial_spectrum_score(_scene(SLOW), _answer(_streams(SLOW, seed))) < FALSE_ALARM


@pytest.mark.parametrize(
    "fault",
    [
        replace(SLOW, density=4e-3),
        replace(SLOW, density=2.1e-3),
        replace(SLOW, random_walk=0.02),
        replace(SLOW, instability=0.02),
    ],
    ids=["doubled sigma", "five per cent", "walk", "instability"],
)
def test_a_wrong_level_is_seen_in_the_spectrum(fault: AxisNoise) -> None:
    assert inertial_spectrum_score(_scene(SLOW), _answer(_streams(fault))) > FALSE_ALARM


def test_the_spectrum_of_differences_integrates_to_their_variance() -> None:
    """2 N^2/T + K^2 T + 2 s^2 (1 - m), the last for a Markov process of memory m."""
    turn = 2 * np.pi * (np.arange(200_000) + 0.5) / 400_000
    sigma, memory = SLOW.instability / 0.617364, np.exp(-1 / RATE / SLOW.instability_time)
    variance = 2 * SLOW.density**2 * RATE + SLOW.random_walk**2 / RATE + 2 * sigma**2 * (1 - memory)
    assert difference_spectrum(SLOW, turn, 1 / RATE).mean() == pytest.approx(variance, rel=1e-6)


@pytest.mark.parametrize("metric", [inertial_histogram_score, inertial_distribution_distance], ids=lambda m: m.name)
def test_a_doubled_sigma_and_a_uniform_shape_are_seen_in_the_distribution(metric: Callable[..., float]) -> None:
    alarm = FALSE_ALARM if metric is inertial_histogram_score else FALSE_DISTANCE
    assert metric(_scene(), _answer(_streams(replace(LAW, density=4e-3)))) > alarm
    flat = _streams(replace(LAW, density=0.0, random_walk=0.0))
    spread = LAW.density * np.sqrt(RATE) * np.sqrt(3)
    shape = np.random.default_rng(2).uniform(-spread, spread, (COUNT, 3))
    assert metric(_scene(), _answer(flat | {"imu/gyroscope": flat["imu/gyroscope"] + shape})) > alarm
    with pytest.raises(NotMeasurable, match="bias instability"):
        metric(_scene(SLOW), _answer(_streams(SLOW)))


def test_a_stream_shared_by_two_sensors_is_seen() -> None:
    scene = _scene()
    twin = replace(scene, sensors=(*scene.sensors, replace(scene.sensors[0], name="twin")))  # type: ignore[arg-type]
    apart = _streams(LAW) | _streams(LAW, name="twin")
    assert inertial_correlation_score(twin, _answer(apart)) < 4.0
    shared = apart | {"twin/gyroscope": apart["imu/gyroscope"]}
    assert inertial_correlation_score(twin, _answer(shared)) > 0.99 * np.sqrt((COUNT - 1) / 1.5)


def test_a_stream_shared_with_a_late_sensor_is_seen_although_that_one_has_fewer_readings() -> None:
    """Generators that share a seed agree draw by draw: the correlation of what both have drawn is 1."""
    scene = _scene()
    twin = replace(scene, sensors=(*scene.sensors, replace(scene.sensors[0], name="twin", latency=0.015)))  # type: ignore[arg-type]
    late = {name: stream[:-3] for name, stream in _streams(LAW, name="twin").items()}
    apart = _streams(LAW) | late
    assert inertial_correlation_score(twin, _answer(apart)) < 4.0
    for channel in ("gyroscope", "accelerometer"):
        shared = apart | {f"twin/{channel}": apart[f"imu/{channel}"][:-3]}
        assert inertial_correlation_score(twin, _answer(shared)) > 0.99 * np.sqrt((COUNT - 4) / 1.5)


def test_all_pairs_of_the_case_are_compared() -> None:
    """Any axis of one sensor that carries any other axis of any sensor is seen: 66 pairs of twelve axes."""
    axes = [(sensor, channel, axis) for sensor in ("left", "right") for channel in CHANNELS for axis in range(3)]
    case_scene = sensor_streams.CASE.scene(sensor_streams.CASE.parameters)
    sound = _case_streams()
    assert inertial_correlation_score(case_scene, _answer(sound)) < 4.0
    pairs = list(itertools.combinations(axes, 2))
    assert len(pairs) == sensor_streams.PAIRS == 66
    for (one, a, i), (other, b, j) in pairs:
        spoilt = {name: stream.copy() for name, stream in sound.items()}
        count = min(len(spoilt[f"{one}/{a}"]), len(spoilt[f"{other}/{b}"]))
        spoilt[f"{other}/{b}"][:count, j] = spoilt[f"{one}/{a}"][:count, i]
        assert inertial_correlation_score(case_scene, _answer(spoilt)) > 50.0, (one, a, i, other, b, j)


@pytest.mark.parametrize("true", [0.0, 0.005, 0.0123, -0.007])
def test_a_delay_is_found_between_the_samples(true: float) -> None:
    time = np.arange(300) * 0.01

    def signal(t: Floats) -> Floats:
        return np.stack([np.sin(9 * t), np.cos(7 * t), t * t], axis=1)

    # The spline's error is (w h)^4/384 of the amplitude, some 2e-7, over a slope of the order of w.
    assert delay(time, signal(time - true), signal(time), 0.05) == pytest.approx(true, abs=1e-7)


def _lagged(by: float, native: float, latency: float = 0.0) -> tuple[Scene, Trajectory, Trajectory]:
    scene = _scene(latency=latency)
    time = np.arange(5, 400) / RATE

    def signal(t: Floats) -> Floats:
        return np.stack([np.sin(9 * t), np.cos(7 * t), 0 * t], axis=1)

    told = {"imu/time": time, "imu/native": np.full(len(time), native)}
    told |= {"imu/accelerometer": signal(time - by), "imu/gyroscope": signal(time - latency)}
    truth = {"imu/time": time, "imu/accelerometer_instant": signal(time), "imu/gyroscope_instant": signal(time)}
    return scene, _answer(told), _answer(truth)


def test_half_an_interval_is_due_to_a_difference_and_none_to_an_engines_own_sensor() -> None:
    assert accelerometer_lag_error(*_lagged(0.005, native=0.0)) < 1e-7
    assert accelerometer_lag_error(*_lagged(0.0, native=1.0)) < 1e-7
    assert accelerometer_lag_error(*_lagged(0.025, native=0.0, latency=0.02)) < 1e-7
    assert gyroscope_lag_error(*_lagged(0.025, native=0.0, latency=0.02)) < 1e-7
    # A difference that passes for the engine's own sensor, a latency that was forgotten, and one step too many.
    assert accelerometer_lag_error(*_lagged(0.005, native=1.0)) == pytest.approx(0.005, abs=1e-6)
    assert accelerometer_lag_error(*_lagged(0.005, native=0.0, latency=0.02)) == pytest.approx(0.02, abs=1e-6)
    assert accelerometer_lag_error(*_lagged(0.015, native=0.0)) == pytest.approx(0.01, abs=1e-6)
    scene, told, truth = _lagged(0.0, native=1.0)
    told.streams["imu/accelerometer"][100, 1] = np.nan  # type: ignore[index]
    assert np.isnan(accelerometer_lag_error(scene, told, truth))


def test_stamps_are_judged_one_by_one() -> None:
    scene = replace(_scene(latency=0.005), sensors=(*_scene(latency=0.005).sensors, Lidar(name="l", body="b", rate=10.0)))
    good = {"imu/time": np.arange(2, 101) / RATE, "l/time": np.arange(11) / 10}
    assert time_stamp_error(scene, _answer(good, 1.0)) < 1e-15
    late = good | {"imu/time": good["imu/time"] + 1e-6 * (np.arange(99) == 7)}
    assert time_stamp_error(scene, _answer(late, 1.0)) == pytest.approx(1e-6)
    for lost in (good["imu/time"][1:], good["imu/time"][:-1], np.delete(good["imu/time"], 40)):
        assert time_stamp_error(scene, _answer(good | {"imu/time": lost}, 1.0)) == np.inf
    bad = good["l/time"].copy()
    bad[3] = np.nan
    assert np.isnan(time_stamp_error(scene, _answer(good | {"l/time": bad}, 1.0)))


EVERY, TURNS = 0.01, 200
"""s between two readings of a turning gyroscope, and how many there are."""


def _rate(t: Floats) -> Floats:
    """Goes round in B: w_B = (cos 3t, sin 3t, 2)."""
    return np.stack([np.cos(3 * t), np.sin(3 * t), 2 + 0 * t], axis=-1)


@cache
def _attitudes() -> Floats:
    """Of a body with that rate, integrated in small steps as the truth; they are only copied."""
    fine = 20
    time = np.arange(TURNS * fine + 1) * EVERY / fine
    # A rotation by the rate in the middle of a small step errs by its third power.
    turns = Rotation.from_rotvec(_rate((time[:-1] + time[1:]) / 2) * EVERY / fine)
    here, attitudes = Rotation.from_quat(axis_angle((1, 1, 0), 0.5), scalar_first=True), []
    attitudes.append(here.as_quat(scalar_first=True))
    for k, turn in enumerate(turns):
        here = here * turn
        if (k + 1) % fine == 0:
            attitudes.append(here.as_quat(scalar_first=True))
    return np.array(attitudes)


def _coning(late: float = 0.0, swapped: bool = False) -> tuple[Scene, Trajectory]:
    """What a gyroscope reads on a body whose rate goes round, and the body's motion."""
    stamps = np.arange(TURNS + 1) * EVERY
    run = Trajectory.of(stamps, 1)
    run.q_WB[:, 0] = _attitudes()
    run.w_WB[:, 0] = Rotation.from_quat(run.q_WB[:, 0], scalar_first=True).apply(_rate(stamps))
    mount = axis_angle((0.2, 1.0, 0.3), 0.7)
    read = Rotation.from_quat(mount, scalar_first=True).inv().apply(_rate(stamps[1:] - late))
    scene = _scene(q_BS=mount)
    streams = {"imu/time": stamps[1:], "imu/gyroscope_ideal": read[:, [1, 0, 2]] if swapped else read}
    return scene, replace(run, streams=streams)


def test_an_integrated_gyroscope_gives_the_bodys_attitude_and_a_late_or_swapped_one_does_not() -> None:
    # The Magnus step with rates at its ends errs by |w''| T^2/12 a second: 9 * 1e-4/12 over 2 s.
    assert gyroscope_attitude_error(*_coning()) < 1.1 * 2 * 9e-4 / 12
    assert gyroscope_attitude_error(*_coning(late=0.01)) > 5e-3
    assert gyroscope_attitude_error(*_coning(swapped=True)) > 0.1
    scene, run = _coning()
    run.streams["imu/gyroscope_ideal"][5, 0] = np.nan  # type: ignore[index]
    assert np.isnan(gyroscope_attitude_error(scene, run))
