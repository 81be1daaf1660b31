"""The trend of a long series: a planted drift is secular, a bounded oscillation is not, noise covers its slope."""

import numpy as np
import pytest

from plumbline.harness.statistics.order import fit_slope

TIME = np.linspace(0.0, 1000.0, 4001)


def test_a_planted_drift_is_found_with_an_interval_around_it() -> None:
    noise = np.random.default_rng(0).normal(0.0, 1e-3, len(TIME))
    fit = fit_slope(TIME.tolist(), (2e-5 * TIME + noise).tolist())
    assert fit is not None
    assert fit.low < 2e-5 < fit.high
    assert fit.high - fit.low < 1e-6
    assert fit.secular


@pytest.mark.parametrize("period", [0.7, 13.0, 333.0])
def test_an_oscillation_is_bounded_however_slow(period: float) -> None:
    fit = fit_slope(TIME.tolist(), np.sin(2 * np.pi * TIME / period).tolist())
    assert fit is not None
    assert not fit.secular


def test_a_trend_that_is_certain_and_smaller_than_the_swing_is_not_secular() -> None:
    """A tenth in all beside a swing from -1 to 1: block means know it well, and it is lost in the swing all the same."""
    fit = fit_slope(TIME.tolist(), (1e-4 * TIME + np.sin(2 * np.pi * TIME / 0.7)).tolist())
    assert fit is not None
    assert fit.low > 0.0
    assert fit.low < 1e-4 < fit.high
    assert not fit.secular


def test_the_interval_covers_a_slope_of_zero_as_often_as_it_says() -> None:
    draw = np.random.default_rng(1)
    fits = [fit_slope(TIME.tolist(), draw.normal(size=len(TIME)).tolist()) for _ in range(200)]
    covered = sum(fit is not None and fit.low <= 0 <= fit.high for fit in fits)
    # 190 of 200 are expected; fewer than 180 come about once in a thousand times.
    assert covered >= 180


def test_too_few_samples_have_no_trend() -> None:
    assert fit_slope([0.0, 1.0], [0.0, 1.0]) is None
