"""Noise of sensors: independent streams, the laws' statistics, and repetition bit by bit."""

import numpy as np
import pytest
from scipy import stats

from plumbline.harness.metrics.inertial_noise import expected_variance, overlapping_variance
from plumbline.harness.scene import AxisNoise, LidarNoise
from plumbline.harness.sensors.imu import MARKOV_PEAK, axis_noise, three_axes
from plumbline.harness.sensors.lidar import noisy
from plumbline.harness.sensors.reader import generator

LAW = AxisNoise(density=2e-4, bias=0.02, instability=1e-3, instability_time=0.2, random_walk=1.5e-3)


def _largest_correlation(streams: np.ndarray) -> float:
    """Of all pairs of rows, in blocks."""
    rows = streams - streams.mean(axis=1, keepdims=True)
    # Single precision: 1e-6 of a correlation, where the bound is a third.
    rows = (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)
    largest = 0.0
    for start in range(0, len(rows), 1000):
        block = np.abs(rows[start : start + 1000] @ rows[start:].T)
        block[np.arange(len(block)), np.arange(len(block))] = 0.0
        largest = max(largest, float(block.max()))
    return largest


def _correlation_bound(streams: int, samples: int) -> float:
    """Exceeded once in a million sets: r^2 of two independent normal samples is Beta(1/2, (n - 2)/2), for every pair."""
    pairs = streams * (streams - 1) / 2
    return float(np.sqrt(stats.beta.isf(1e-6 / pairs, 0.5, (samples - 2) / 2)))


# Each seed has two hundred streams: two thousand, and ten thousand.
@pytest.mark.parametrize("seeds", [10, pytest.param(50, marks=pytest.mark.slow)])
def test_streams_of_seeds_sensors_channels_and_axes_are_independent(seeds: int) -> None:
    streams = np.array(
        [
            generator(seed, f"imu {sensor}", channel, axis).standard_normal(200)
            for seed in range(seeds)
            for sensor in range(20)
            for channel in ("accelerometer", "gyroscope")
            for axis in range(5)
        ]
    )
    assert len(streams) == 200 * seeds
    bound = _correlation_bound(*streams.shape)
    assert _largest_correlation(streams) < bound
    # The planted fault: two of them share a seed. All other pairs were looked at above.
    streams[1477] = streams[42]
    assert _largest_correlation(streams[7:1478:35]) > bound


@pytest.mark.parametrize(("seeds", "less"), [(10, 0.75), pytest.param(50, 0.9, marks=pytest.mark.slow)])
def test_streams_begin_with_different_words_and_their_beginnings_are_even(seeds: int, less: float) -> None:
    keys = [
        (seed, f"imu {sensor}", channel, axis)
        for seed in range(seeds)
        for sensor in range(20)
        for channel in "ag"
        for axis in range(5)
    ]
    words = np.array([generator(*key).bit_generator.random_raw() for key in keys], dtype=np.uint64)
    assert len(words) == 200 * seeds
    # Two of 10^4 words of 64 bits are equal in 3 of a million million sets.
    assert len(np.unique(words)) == len(words)
    firsts = np.array([generator(*key).standard_normal() for key in keys])
    assert stats.kstest(firsts, "norm").pvalue > 0.01
    # Planted: one stream of two seeds, and streams that all begin alike but for a little.
    assert len(np.unique(np.concatenate([words, words[:1]]))) == len(words)
    assert stats.kstest(less * firsts, "norm").pvalue < 1e-4


def test_the_same_key_repeats_bit_by_bit_and_any_other_part_of_it_does_not() -> None:
    first = generator(1, "imu", "gyroscope", 0).random(8)
    np.testing.assert_array_equal(first, generator(1, "imu", "gyroscope", 0).random(8))
    for other in ((2, "imu", "gyroscope", 0), (1, "imv", "gyroscope", 0), (1, "imu", "gyro", 0), (1, "imu", "gyroscope", 1)):
        assert not np.any(first == generator(*other).random(8))


def test_a_longer_record_begins_with_the_shorter_one() -> None:
    long, short = (three_axes(LAW, count, 0.01, 3, "imu", "gyroscope") for count in (500, 200))
    # The filters sum in the order of time, so that not even rounding differs.
    np.testing.assert_array_equal(long[:200], short)


def test_a_law_without_noise_is_its_bias() -> None:
    np.testing.assert_array_equal(axis_noise(AxisNoise(bias=0.3), 10, 0.01, 1, "imu", "gyroscope", 0), np.full(10, 0.3))


@pytest.mark.parametrize(
    ("law", "m", "deviation"),
    [
        # N/sqrt(tau), K sqrt(tau/3) with the discrete sum's 1 + 1/(2 m^2), and the floor itself at 1.89 correlation times.
        (AxisNoise(density=0.02), 50, 0.02 / np.sqrt(0.5)),
        (AxisNoise(random_walk=0.02), 50, 0.02 * np.sqrt(0.5 / 3 * (1 + 1 / 5000))),
        (AxisNoise(instability=0.02, instability_time=0.5), 95, 0.02),
    ],
    ids=["white", "random walk", "instability"],
)
def test_each_process_has_the_allan_deviation_of_the_standard(law: AxisNoise, m: int, deviation: float) -> None:
    count, axes = 40_000, 8
    mean, freedom = expected_variance(law, m, count, 0.01)
    # The discretisation of a Markov process at 50 samples a correlation time is 1e-4 of it.
    assert np.sqrt(mean) == pytest.approx(deviation, rel=1e-3)
    noise = np.stack([axis_noise(law, count, 0.01, 5, "imu", "gyroscope", axis) for axis in range(axes)], axis=1)
    found = overlapping_variance(noise, m).mean()
    # Five standard deviations of a chi-squared mean with this many degrees of freedom.
    assert found == pytest.approx(mean, rel=5 * np.sqrt(2 / (freedom * axes)))


def test_the_markov_process_is_stationary_from_its_first_sample_and_forgets_as_told() -> None:
    law = AxisNoise(instability=1.0, instability_time=0.1)
    rows = np.stack([axis_noise(law, 31, 0.01, seed, "imu", "gyroscope", 0) for seed in range(2000)])
    sigma = 1.0 / MARKOV_PEAK
    # Variance of a variance of 2000 normal samples is 2/2000; of a correlation rho, (1 - rho^2)^2/2000.
    np.testing.assert_allclose(rows.var(axis=0), sigma**2, rtol=5 * np.sqrt(2 / 2000))
    found = np.corrcoef(rows[:, 0], rows[:, 10])[0, 1]
    assert found == pytest.approx(np.exp(-1.0), abs=5 * (1 - np.exp(-2)) / np.sqrt(2000))


def test_overlapping_allan_variance_equals_its_definition() -> None:
    signal = np.random.default_rng(1).standard_normal((40, 2)).cumsum(axis=0)
    for m in (1, 3, 7):
        means = np.array([signal[i : i + m].mean(axis=0) for i in range(40 - m + 1)])
        expected = 0.5 * np.mean(np.square(means[m:] - means[:-m]), axis=0)
        np.testing.assert_allclose(overlapping_variance(signal, m), expected, rtol=1e-12)


@pytest.mark.parametrize("records", [800, pytest.param(3000, marks=pytest.mark.slow)])
def test_the_expected_variance_has_the_spread_that_many_records_show(records: int) -> None:
    count, m = 2000, 64
    mean, freedom = expected_variance(LAW, m, count, 1 / 120)
    noise = np.stack([axis_noise(LAW, count, 1 / 120, seed, "imu", "gyroscope", 0) for seed in range(records)], axis=1)
    found = overlapping_variance(noise, m)
    assert found.mean() == pytest.approx(mean, rel=5 * np.sqrt(2 / freedom / records))
    # A sample variance errs by sqrt((kurtosis - 1)/records) of itself; the kurtosis of these sums is below 4.5.
    assert found.var() / (2 * mean**2 / freedom) == pytest.approx(1.0, rel=5 * np.sqrt(3.5 / records))


def test_range_noise_grows_with_range_and_drops_beams_without_touching_misses() -> None:
    law = LidarNoise(range_sigma=0.01, range_sigma_slope=0.02, dropout=0.2)
    ranges = np.repeat([[[1.0, 10.0, np.inf]]], 40_000, axis=0)
    found, heard = noisy(law, ranges, np.where(np.isinf(ranges), 0.0, 0.7), 1, "lidar")
    assert np.isinf(found[..., 2]).all()
    assert (heard[..., 2] == 0).all()
    for column, sigma in ((0, 0.03), (1, 0.21)):
        returned = np.isfinite(found[:, 0, column])
        n = returned.sum()
        assert abs(np.mean(~returned) - 0.2) < 5 * np.sqrt(0.2 * 0.8 / 40_000)
        assert found[returned, 0, column].std() == pytest.approx(sigma, rel=5 / np.sqrt(2 * n))
        np.testing.assert_array_equal(heard[:, 0, column], np.where(returned, 0.7, 0.0))
