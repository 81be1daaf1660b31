"""Inertial noise metrics: noise of the law passes in many seeds, and each planted fault is seen by the metric meant for it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.inertial_noise import (
    SLOPES,
    accelerometer_allan_score,
    gyroscope_allan_score,
    inertial_bias_score,
    inertial_correlation_score,
    octaves,
    slope_bound,
    variance_of_mean,
    windows,
)
from plumbline.harness.metrics.readings import accelerometer_ideal_error, gyroscope_ideal_error
from plumbline.harness.scene import AxisNoise, Body, Imu, ImuNoise, Scene
from plumbline.harness.sensors.imu import axis_noise, three_axes
from plumbline.harness.trajectory import Floats, Trajectory

RATE, COUNT = 120.0, 12_000
LAW = AxisNoise(density=2e-4, bias=0.02, instability=1e-3, instability_time=0.2, random_walk=1.5e-3)
SENSOR = Imu(name="imu", body="b", rate=RATE, noise=ImuNoise(accelerometer=LAW, gyroscope=LAW))
SCENE = Scene(bodies=(Body(name="b"),), sensors=(SENSOR,))
SCORES = (gyroscope_allan_score, accelerometer_allan_score, inertial_bias_score, inertial_correlation_score)
FALSE_ALARM = 5.0


def _streams(law: AxisNoise = LAW, seed: int = 1) -> dict[str, Floats]:
    """Noise on a signal that is not zero, in a dictionary of the caller's own; its arrays are everybody's."""
    return dict(_made(law, seed))


@cache
def _made(law: AxisNoise, seed: int) -> dict[str, Floats]:
    time = np.arange(1, COUNT + 1) / RATE
    streams = {"imu/time": time}
    for channel in ("accelerometer", "gyroscope"):
        ideal = np.stack([np.sin(time), np.cos(time), 0 * time], axis=1)
        streams[f"imu/{channel}_ideal"] = ideal
        streams[f"imu/{channel}"] = ideal + three_axes(law, COUNT, 1 / RATE, seed, "imu", channel)
    for array in streams.values():
        array.flags.writeable = False
    return streams


def _answer(streams: dict[str, Floats]) -> Trajectory:
    return replace(Trajectory.of(np.zeros(1), 1), streams=streams)


@pytest.mark.parametrize("seeds", [30, pytest.param(100, marks=pytest.mark.slow)])
def test_noise_of_the_law_raises_no_alarm_in_many_seeds_and_scores_as_normal_variables_do(seeds: int) -> None:
    found = np.array([[metric(SCENE, _answer(_streams(seed=seed))) for metric in SCORES] for seed in range(seeds)])
    assert found.max() < FALSE_ALARM
    # The largest of k independent scores has the median at which the two-sided probability is 1 - 2^(-1/k). Overlapping octaves
    # are correlated, which lowers it; a median outside [0.6 of it, it + 0.3] would show a wrong variance.
    for column, k in enumerate((3 * len(octaves(COUNT)),) * 2 + (6, 15)):
        from scipy import stats

        expected = stats.norm.isf((1 - 0.5 ** (1 / k)) / 2)
        assert 0.6 * expected < np.median(found[:, column]) < expected + 0.3


@pytest.mark.parametrize("seeds", [15, pytest.param(30, marks=pytest.mark.slow)])
def test_slopes_of_the_law_stay_within_their_bounds(seeds: int) -> None:
    for seed in range(seeds):
        for (_channel, regime), metric in SLOPES.items():
            assert metric(SCENE, _answer(_streams(seed=seed))) < slope_bound(LAW, regime, COUNT, 1 / RATE)


@pytest.mark.parametrize(
    "change",
    [
        {"density": 4e-4},
        {"density": 2.1e-4},
        {"instability": 2e-3},
        {"instability": 0.0},
        {"random_walk": 4.5e-3},
        {"random_walk": 0.0},
        {"instability_time": 2.0},
    ],
    ids=str,
)
def test_noise_of_another_law_is_seen_by_the_allan_deviation(change: dict[str, float]) -> None:
    wrong = replace(LAW, **change)
    for metric in (gyroscope_allan_score, accelerometer_allan_score):
        assert metric(SCENE, _answer(_streams(wrong))) > FALSE_ALARM


def test_each_slope_sees_a_law_of_another_colour() -> None:
    white, walk = AxisNoise(density=2e-4), AxisNoise(random_walk=1.5e-3)
    for regime, wrong in (("white", walk), ("floor", white), ("floor", walk), ("random_walk", white)):
        metric = SLOPES["gyroscope", regime]
        assert metric(SCENE, _answer(_streams(wrong))) > slope_bound(LAW, regime, COUNT, 1 / RATE)


def test_a_bias_off_by_a_third_is_seen_and_a_pure_bias_is_not() -> None:
    assert inertial_bias_score(SCENE, _answer(_streams(replace(LAW, bias=0.0)))) > FALSE_ALARM
    pure = AxisNoise(bias=0.02)
    scene = replace(SCENE, sensors=(replace(SENSOR, noise=ImuNoise(accelerometer=pure, gyroscope=pure)),))
    assert inertial_bias_score(scene, _answer(_streams(pure))) < 1.0
    assert inertial_bias_score(scene, _answer(_streams(replace(pure, bias=0.0200001)))) > FALSE_ALARM


@pytest.mark.parametrize("records", [500, pytest.param(2000, marks=pytest.mark.slow)])
def test_the_variance_of_a_mean_is_that_of_many_records(records: int) -> None:
    rows = np.stack([axis_noise(replace(LAW, bias=0.0), 300, 1 / RATE, s, "imu", "gyroscope", 0) for s in range(records)])
    for count in (1, 17, 300):
        expected = float(variance_of_mean(LAW, np.array([float(count)]), 1 / RATE)[0])
        # A variance of so many normal means errs by sqrt(2 / records), five times.
        assert rows[:, :count].mean(axis=1).var() == pytest.approx(expected, rel=5 * np.sqrt(2 / records))


def test_a_shared_seed_is_seen_between_axes_and_between_channels() -> None:
    streams = _streams()
    shared = streams["imu/gyroscope"].copy()
    shared[:, 1] = streams["imu/gyroscope_ideal"][:, 1] + (shared - streams["imu/gyroscope_ideal"])[:, 0]
    assert inertial_correlation_score(SCENE, _answer(streams | {"imu/gyroscope": shared})) > FALSE_ALARM
    noise = streams["imu/gyroscope"] - streams["imu/gyroscope_ideal"]
    across = streams | {"imu/accelerometer": streams["imu/accelerometer_ideal"] + noise}
    assert inertial_correlation_score(SCENE, _answer(across)) > FALSE_ALARM


def test_one_bad_sample_makes_every_score_non_finite() -> None:
    for channel in ("accelerometer", "gyroscope"):
        streams = _streams()
        streams[f"imu/{channel}"] = streams[f"imu/{channel}"].copy()
        streams[f"imu/{channel}"][5, 1] = np.nan
        own = gyroscope_allan_score if channel == "gyroscope" else accelerometer_allan_score
        for metric in (own, inertial_bias_score, inertial_correlation_score):
            assert not np.isfinite(metric(SCENE, _answer(streams)))


def test_sensors_without_noise_and_streams_that_are_missing_are_not_measurable() -> None:
    quiet = replace(SCENE, sensors=(replace(SENSOR, noise=None),))
    for metric in (*SCORES, *SLOPES.values()):
        with pytest.raises(NotMeasurable):
            metric(quiet, _answer(_streams()))
        with pytest.raises(NotMeasurable):
            metric(SCENE, _answer({}))


def test_windows_show_only_what_the_law_has_and_the_record_holds() -> None:
    assert set(windows(LAW, COUNT, 1 / RATE)) == {"white", "floor", "random_walk"}
    assert set(windows(replace(LAW, instability_time=100.0, random_walk=0.0), COUNT, 1 / RATE)) == {"white"}


def test_an_ideal_signal_is_compared_at_its_time_stamps() -> None:
    truth = _answer(_streams())
    assert accelerometer_ideal_error(SCENE, truth, truth) == 0.0
    off = _streams()
    off["imu/gyroscope_ideal"] = off["imu/gyroscope_ideal"] + np.array([0.0, 3e-3, 4e-3])
    assert gyroscope_ideal_error(SCENE, _answer(off), truth) == pytest.approx(5e-3, rel=1e-9)
    assert accelerometer_ideal_error(SCENE, _answer(off), truth) == 0.0
    late = _streams()
    late["imu/time"] = late["imu/time"] + 1 / RATE
    assert gyroscope_ideal_error(SCENE, _answer(late), truth) == np.inf
    late["imu/time"] = late["imu/time"][:-1]
    assert gyroscope_ideal_error(SCENE, _answer(late), truth) == np.inf
    off["imu/gyroscope_ideal"][3, 0] = np.nan
    assert not np.isfinite(gyroscope_ideal_error(SCENE, _answer(off), truth))
    with pytest.raises(NotMeasurable, match="truth"):
        gyroscope_ideal_error(SCENE, truth)
