"""The fitted order of convergence against errors that are made with a known order."""

import numpy as np
import pytest

from harness.trend import fit_order

LADDER = [1 / 60 / 2**k for k in range(8)]


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_a_pure_power_law_gives_its_order_exactly_and_no_floor(order: float) -> None:
    fit = fit_order(LADDER, [3.0 * dt**order for dt in LADDER])
    assert fit is not None
    assert fit.order == pytest.approx(order, abs=1e-9)  # the logarithms are a line up to rounding, 1e-16 relative
    assert fit.floor is None
    assert fit.used == len(LADDER)


def test_a_floor_is_found_and_kept_out_of_the_slope() -> None:
    errors = [max(dt**2, 3e-7) for dt in LADDER]
    fit = fit_order(LADDER, errors)
    assert fit is not None
    above = sum(dt**2 > 3e-7 for dt in LADDER)
    assert fit.used == above
    assert fit.order == pytest.approx(2.0, abs=1e-9)
    assert fit.floor == pytest.approx(3e-7, rel=1e-9)


def test_the_interval_holds_the_true_order_in_about_nineteen_of_twenty_noisy_ladders() -> None:
    random = np.random.default_rng(1)
    fits = [fit_order(LADDER, [dt**2 * np.exp(0.1 * random.standard_normal()) for dt in LADDER]) for _ in range(400)]
    held = sum(fit is not None and fit.low <= 2.0 <= fit.high for fit in fits)
    # Binomial: 380 expected, standard deviation 4.4; choosing the split costs coverage, so only the lower side is allowed more.
    assert 340 <= held <= 394


def test_one_stray_point_at_the_fine_end_is_no_floor() -> None:
    errors = [dt**2 for dt in LADDER]
    errors[-1] /= 5.0
    fit = fit_order(LADDER, errors)
    assert fit is not None
    assert fit.floor is None
    assert fit.used == len(LADDER)


def test_the_order_of_the_points_does_not_matter() -> None:
    errors = [dt**1.5 for dt in LADDER]
    assert fit_order(LADDER[::-1], errors[::-1]) == fit_order(LADDER, errors)


@pytest.mark.parametrize(
    ("dt", "error"),
    [([], []), ([0.1, 0.01], [1.0, 0.1]), ([0.1, 0.01, 0.001], [0.0, np.nan, 1.0]), ([0.1, 0.1, 0.1], [1.0, 2.0, 3.0])],
)
def test_too_few_usable_points_give_no_order(dt: list[float], error: list[float]) -> None:
    assert fit_order(dt, error) is None


def test_zeros_and_nan_are_left_out_of_the_fit() -> None:
    errors = [dt**2 for dt in LADDER]
    errors[3], errors[5] = 0.0, float("nan")
    fit = fit_order(LADDER, errors)
    assert fit is not None
    assert fit.used == len(LADDER) - 2
    assert fit.order == pytest.approx(2.0, abs=1e-9)
