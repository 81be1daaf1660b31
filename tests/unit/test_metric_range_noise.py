"""Range metrics: noise of the law passes in many seeds; doubled sigma, shared seeds, biased dropout and wrong rays are seen."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.ranges import (
    dropout_score,
    intensity_error_max,
    range_correlation_score,
    range_distribution_distance,
    range_error_max,
    range_error_median,
    range_error_rms,
    range_false_return_share,
    range_mean_score,
    range_spread_score,
)
from plumbline.harness.scene import Body, Lidar, LidarNoise, Scene
from plumbline.harness.sensors.lidar import noisy
from plumbline.harness.trajectory import Floats, Trajectory

LAW = LidarNoise(range_sigma=0.02, range_sigma_slope=0.002, dropout=0.05)
SENSOR = Lidar(name="l", body="b", rate=10.0, channels=16, columns=60, noise=LAW)
SCENE = Scene(bodies=(Body(name="b"),), sensors=(SENSOR,))
SCORES = (range_mean_score, range_spread_score, range_correlation_score, dropout_score)
FALSE_ALARM, FALSE_DISTANCE = 5.0, 2.73


def _streams(law: LidarNoise = LAW, seed: int = 1) -> dict[str, Floats]:
    """Ten scans of ranges from 2 to 9 m; every 50th beam meets nothing."""
    shape = (10, SENSOR.channels, SENSOR.columns)
    ranges = 2.0 + 7.0 * np.random.default_rng(5).random(shape)
    ranges.ravel()[::50] = np.inf
    intensity = np.where(np.isinf(ranges), 0.0, 0.5)
    heard = noisy(law, ranges, intensity, seed, "l")
    return {
        "l/time": np.arange(10) / 10,
        "l/range_ideal": ranges,
        "l/intensity_ideal": intensity,
        "l/range": heard[0],
        "l/intensity": heard[1],
    }


def _answer(streams: dict[str, Floats]) -> Trajectory:
    return replace(Trajectory.of(np.zeros(1), 1), streams=streams)


@pytest.mark.parametrize("seeds", [60, pytest.param(200, marks=pytest.mark.slow)])
def test_noise_of_the_law_raises_no_alarm_in_many_seeds_and_scores_as_normal_variables_do(seeds: int) -> None:
    answers = [_answer(_streams(seed=seed)) for seed in range(seeds)]
    for metric in (range_mean_score, range_spread_score, dropout_score):
        found = np.array([metric(SCENE, answer) for answer in answers])
        assert found.max() < FALSE_ALARM
        # |z| of a normal variable has the mean sqrt(2/pi) and the variance 1 - 2/pi.
        assert found.mean() == pytest.approx(np.sqrt(2 / np.pi), abs=5 * np.sqrt((1 - 2 / np.pi) / seeds))
    assert max(range_correlation_score(SCENE, answer) for answer in answers) < FALSE_ALARM
    assert max(range_distribution_distance(SCENE, answer) for answer in answers) < FALSE_DISTANCE


@pytest.mark.parametrize(
    "law", [replace(LAW, range_sigma=0.04), replace(LAW, range_sigma_slope=0.0), replace(LAW, range_sigma=0.0)]
)
def test_a_wrong_sigma_is_seen_in_spread_and_distribution(law: LidarNoise) -> None:
    answer = _answer(_streams(law))
    assert range_spread_score(SCENE, answer) > FALSE_ALARM
    assert range_distribution_distance(SCENE, answer) > FALSE_DISTANCE


@pytest.mark.parametrize("rate", [0.0, 0.03, 0.07, 0.5])
def test_a_wrong_dropout_rate_is_seen(rate: float) -> None:
    assert dropout_score(SCENE, _answer(_streams(replace(LAW, dropout=rate)))) > FALSE_ALARM


def test_a_return_from_nothing_is_no_dropout() -> None:
    streams = _streams()
    streams["l/range"][np.isinf(streams["l/range_ideal"])] = 3.0
    assert dropout_score(SCENE, _answer(streams)) == np.inf


def test_a_law_without_dropout_allows_none() -> None:
    scene = replace(SCENE, sensors=(replace(SENSOR, noise=replace(LAW, dropout=0.0)),))
    assert dropout_score(scene, _answer(_streams(replace(LAW, dropout=0.0)))) == 0.0
    assert dropout_score(scene, _answer(_streams(replace(LAW, dropout=0.001)))) == np.inf


def test_a_bias_of_a_tenth_of_sigma_is_seen_in_the_mean() -> None:
    streams = _streams()
    streams["l/range"] = streams["l/range"] + 0.003
    assert range_mean_score(SCENE, _answer(streams)) > FALSE_ALARM


def test_noise_of_the_right_spread_but_another_shape_is_seen_in_the_distribution_alone() -> None:
    streams = _streams(replace(LAW, range_sigma=0.0, range_sigma_slope=0.0))
    sigma = 0.02 + 0.002 * np.where(np.isinf(streams["l/range"]), 0.0, streams["l/range"])
    flat = np.random.default_rng(2).uniform(-np.sqrt(3), np.sqrt(3), sigma.shape)
    streams["l/range"] = streams["l/range"] + sigma * flat
    assert range_spread_score(SCENE, _answer(streams)) < FALSE_ALARM
    assert range_distribution_distance(SCENE, _answer(streams)) > FALSE_DISTANCE


@pytest.mark.parametrize("axis", [0, 1, 2], ids=["scans", "channels", "columns"])
def test_a_shared_seed_between_neighbours_is_seen_in_the_correlation(axis: int) -> None:
    law = replace(LAW, dropout=0.0, range_sigma_slope=0.0)
    streams = _streams(law)
    ideal = np.full_like(streams["l/range_ideal"], 5.0)
    one = np.random.default_rng(3).standard_normal(ideal.shape).take([0], axis=axis)
    shared = streams | {"l/range_ideal": ideal, "l/range": ideal + 0.02 * np.broadcast_to(one, ideal.shape)}
    scene = replace(SCENE, sensors=(replace(SENSOR, noise=law),))
    assert range_correlation_score(scene, _answer(shared)) > FALSE_ALARM


def test_ray_errors_are_measured_where_both_hit_and_disagreements_are_counted() -> None:
    truth = _answer(_streams())
    for metric in (range_error_max, range_error_rms, range_error_median, range_false_return_share, intensity_error_max):
        assert metric(SCENE, truth, truth) == 0.0
    off = _streams()
    off["l/range_ideal"][3, 2, 1] += 0.01
    off["l/intensity_ideal"][3, 2, 1] += 0.25
    hits = np.isfinite(off["l/range_ideal"]).sum()
    assert range_error_max(SCENE, _answer(off), truth) == pytest.approx(0.01, rel=1e-9)
    assert range_error_rms(SCENE, _answer(off), truth) == pytest.approx(0.01 / np.sqrt(hits), rel=1e-9)
    assert intensity_error_max(SCENE, _answer(off), truth) == pytest.approx(0.25, rel=1e-9)
    assert range_false_return_share(SCENE, _answer(off), truth) == 0.0
    # A miss that should hit, a hit that should miss, and a hit on another surface.
    off["l/range_ideal"][0, 0, 1], off["l/range_ideal"][0, 0, 0] = np.inf, 4.0
    off["l/range_ideal"][0, 0, 2] *= 1.5
    assert range_false_return_share(SCENE, _answer(off), truth) == pytest.approx(3 / off["l/range_ideal"].size)
    assert range_error_max(SCENE, _answer(off), truth) == pytest.approx(0.01, rel=1e-9)


def test_a_bad_number_is_neither_a_hit_nor_a_miss() -> None:
    truth = _answer(_streams())
    for channel, metrics in (
        ("range_ideal", (range_error_max, range_error_rms, range_error_median, range_false_return_share)),
        ("range", (range_mean_score, range_spread_score, range_distribution_distance, range_correlation_score, dropout_score)),
    ):
        streams = _streams()
        streams[f"l/{channel}"][2, 3, 4] = np.nan
        for metric in metrics:
            assert np.isnan(metric(SCENE, _answer(streams), truth)), metric.name


def test_missing_normals_noise_laws_streams_and_truths_are_not_measurable() -> None:
    truth = _answer(_streams())
    blind = _answer(_streams() | {"l/intensity_ideal": np.full((10, 16, 60), np.nan)})
    with pytest.raises(NotMeasurable, match="normals"):
        intensity_error_max(SCENE, blind, truth)
    with pytest.raises(NotMeasurable, match="truth"):
        range_error_max(SCENE, truth)
    quiet = replace(SCENE, sensors=(replace(SENSOR, noise=None),))
    for metric in (*SCORES, range_distribution_distance):
        with pytest.raises(NotMeasurable):
            metric(quiet, truth)
        with pytest.raises(NotMeasurable):
            metric(SCENE, _answer({}))
