"""Long records of each noise model: levels within three per cent, slopes, distributions, and planted faults."""

from functools import cache

import numpy as np
import pytest
from scipy import stats

from plumbline.harness.metrics.inertial_noise import expected_variance, histogram_score, overlapping_variance
from plumbline.harness.scene import AxisNoise, LidarNoise
from plumbline.harness.sensors.imu import axis_noise
from plumbline.harness.sensors.lidar import noisy
from plumbline.harness.trajectory import Floats

INTERVAL = 0.01
MANY = pytest.mark.parametrize("count", [250_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
WHITE = AxisNoise(density=2e-3)
FLOOR = AxisNoise(instability=1e-3, instability_time=0.2)
WALK = AxisNoise(random_walk=1.5e-3)


def _deviation(noise: Floats, m: int) -> float:
    return float(np.sqrt(overlapping_variance(noise[:, None], m)[0]))


@cache
def _noise(law: AxisNoise, count: int, axis: int = 0) -> Floats:
    """Worked out once, for whoever reads it."""
    noise = axis_noise(law, count, INTERVAL, 1, "imu", "gyroscope", axis)
    noise.flags.writeable = False
    return noise


@MANY
@pytest.mark.parametrize(
    ("law", "short", "long", "slope"),
    [(WHITE, 4, 64, -0.5), (FLOOR, 27, 53, 0.0), (WALK, 16, 256, 0.5)],
    ids=["white", "instability", "walk"],
)
def test_levels_and_slopes_of_the_allan_deviation_lie_within_three_per_cent(
    law: AxisNoise, short: int, long: int, slope: float, count: int
) -> None:
    """With an average of at most 1/3900 of the record the level is known to sqrt(1/3900/2), a little over 1 %."""
    long = min(long, count // 3900)
    noise = _noise(law, count)
    found = [_deviation(noise, m) for m in (short, long)]
    for m, level in zip((short, long), found, strict=True):
        assert level == pytest.approx(np.sqrt(expected_variance(law, m, count, INTERVAL)[0]), rel=0.03)
    # On the flat top the two ends differ by what the law itself gives; elsewhere the slope is pure to 1/(4 m^2).
    assert np.log(found[1] / found[0]) / np.log(long / short) == pytest.approx(slope, abs=0.03)
    doubled = AxisNoise(
        density=2 * law.density,
        instability=2 * law.instability,
        instability_time=law.instability_time,
        random_walk=2 * law.random_walk,
    )
    part = noise[:100_000]
    assert _deviation(_noise(doubled, len(part)), short) == pytest.approx(2 * _deviation(part, short), rel=1e-9)


@MANY
@pytest.mark.parametrize("law", [WHITE, FLOOR, WALK], ids=["white", "instability", "walk"])
def test_what_drives_each_process_is_normal(law: AxisNoise, count: int) -> None:
    """The innovations, taken out of the process by its own definition: Kolmogorov and Smirnov at 1 %, and the histogram.

    The limiting distribution: what it leaves out of a probability is of the order 1 / sqrt(n), 2e-3.
    """
    noise = _noise(law, count)
    memory = np.exp(-INTERVAL / law.instability_time)
    if law is WHITE:
        driving = noise / (law.density / np.sqrt(INTERVAL))
    elif law is FLOOR:
        driving = (noise[1:] - memory * noise[:-1]) / (law.instability / 0.617364 * np.sqrt(1 - memory**2))
    else:
        driving = np.diff(noise) / (law.random_walk * np.sqrt(INTERVAL))
    assert stats.kstest(driving, "norm", method="asymp").pvalue > 0.01
    assert histogram_score(driving) < 5.0
    assert stats.kstest(1.02 * driving, "norm", method="asymp").pvalue < 1e-4
    assert histogram_score(1.02 * driving) > 5.0


@pytest.mark.parametrize("scans", [25, pytest.param(100, marks=pytest.mark.slow)])
def test_range_and_intensity_noise_are_normal_and_beams_are_dropped_as_often_as_told(scans: int) -> None:
    law = LidarNoise(range_sigma=0.02, range_sigma_slope=0.002, dropout=0.05, intensity_sigma=0.01)
    shape = (scans, 10, 1000)
    ranges = 1.0 + 9.0 * np.random.default_rng(3).random(shape)
    heard, light = noisy(law, ranges, np.full(shape, 0.5), 1, "lidar")
    back = np.isfinite(heard)
    assert abs(np.mean(~back) - 0.05) < 0.03 * 0.05
    deviations = ((heard - ranges) / (0.02 + 0.002 * ranges))[back]
    for one in (deviations, ((light - 0.5) / 0.01)[back]):
        assert one.std() == pytest.approx(1.0, rel=0.03)
        assert stats.kstest(one, "norm", method="asymp").pvalue > 0.01
        assert histogram_score(one) < 5.0
        assert stats.kstest(2 * one, "norm", method="asymp").pvalue < 1e-6
    # Nothing that is drawn tells of anything else that is.
    pairs = np.corrcoef([deviations, ((light - 0.5) / 0.01)[back]])[0, 1]
    assert abs(pairs) < 5 / np.sqrt(back.sum())
    dropped = np.mean(~np.isfinite(noisy(LidarNoise(dropout=0.06), ranges, np.full(shape, 0.5), 1, "lidar")[0]))
    assert abs(dropped - 0.05) > 5 * np.sqrt(0.05 * 0.95 / ranges.size)


@MANY
def test_two_axes_share_nothing_and_a_planted_shared_seed_is_caught(count: int) -> None:
    one, other = _noise(WHITE, count, 0), _noise(WHITE, count, 1)
    same = axis_noise(WHITE, count, INTERVAL, 1, "imu", "gyroscope", 0)
    assert abs(np.corrcoef(one, other)[0, 1]) < 5 / np.sqrt(count)
    assert np.corrcoef(one, same)[0, 1] > 0.999
