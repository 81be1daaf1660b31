"""The fitted order of convergence against errors that are made with a known order."""

import numpy as np
import pytest

from plumbline.harness.statistics.order import Order, falls_short, fit_order

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


def _broken(errors: list[float], promised: float, ladder: list[float] = LADDER[:6]) -> bool:
    fit = fit_order(ladder, errors)
    return fit is not None and falls_short(fit, promised)


@pytest.mark.parametrize(("promised", "kept"), [(1, 0.0), (2, 1.0), (4, 1.0), (4, 2.0), (4, 3.0), (8, 4.0)])
def test_a_lost_order_is_a_broken_promise(promised: int, kept: float) -> None:
    assert _broken([dt**kept for dt in LADDER[:6]], promised)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_an_order_as_promised_or_above_is_none(order: int) -> None:
    for promised in range(1, order + 1):
        assert not _broken([dt**order for dt in LADDER[:6]], promised)


LONG_ONES = [
    pytest.param(order, noise, marks=pytest.mark.slow)
    for order in (1, 2, 4)
    for noise in (0.01, 0.1, 0.3, 0.7)
    if (order, noise) not in [(2, 0.1), (4, 0.7)]
]
"""A slope's scatter hangs on the noise alone, whatever the order is; each side of the bound has one ladder without these."""


@pytest.mark.parametrize(("order", "noise"), [(2, 0.1), (4, 0.7), *LONG_ONES])
def test_noise_makes_hardly_a_false_finding_in_a_thousand_ladders(order: int, noise: float) -> None:
    """Student's interval lies below the true order in 2.5 %; half an order lower yet it lies less often.

    At a noise of sigma = 0.7, a factor of two, the slope of six halvings scatters by sigma / (ln 2 sqrt(17.5)) = 0.24, so that
    half an order is two of its standard deviations and the interval still has to miss it: under the 2.5 % by far. The bound of
    25 + 3 sqrt(25) is what 2.5 % of a thousand may reach by chance.
    """
    random = np.random.default_rng(order)
    errors = [[dt**order * np.exp(noise * random.standard_normal()) for dt in LADDER[:6]] for _ in range(1000)]
    assert sum(_broken(one, order) for one in errors) <= (0 if noise <= 0.1 else 25 + 3 * 5)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_an_error_that_passes_through_zero_breaks_no_promise(order: int) -> None:
    """C1 dt^p - C2 dt^(p+1) with its zero anywhere on the ladder, on a step or between two."""
    for zero in np.geomspace(LADDER[5] / 2, LADDER[0] * 2, 400):
        errors = [max(abs(dt**order - dt ** (order + 1) / zero), 1e-3 * dt**order) for dt in LADDER[:6]]
        assert not _broken(errors, order), zero


@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_coarse_beginning_breaks_no_promise(order: int) -> None:
    """The next power of the step as large as the first at the coarsest step, with either sign."""
    for share in (1.0, 0.9, -0.9, -0.5):
        assert not _broken([dt**order * (1 + share * dt / LADDER[0]) for dt in LADDER[:6]], order), share


def test_a_floor_breaks_no_promise_unless_next_to_nothing_was_gained() -> None:
    assert not _broken([max(dt, 3e-3) for dt in LADDER[:6]], 1)
    assert not _broken([max(dt**4, 1e-10) for dt in LADDER[:6]], 4)
    assert _broken([0.26, 0.21, 0.19, 0.18, 0.17, 0.17], 1)


def _fitted(high: float, at_fine_end: float, left: float = 0.0) -> Order:
    order = high - 0.1
    return Order(
        order=order, low=order - 0.1, high=high, used=6, floor=None, coarse=1.0, fine=0.1, at_fine_end=at_fine_end, left=left
    )


def test_a_promise_is_broken_by_the_whole_ladder_and_its_fine_end_together_or_by_what_is_left() -> None:
    assert falls_short(_fitted(high=1.4, at_fine_end=1.4), 2)
    assert not falls_short(_fitted(high=1.4, at_fine_end=1.6), 2)
    assert not falls_short(_fitted(high=1.6, at_fine_end=1.4), 2)
    assert falls_short(_fitted(high=2.1, at_fine_end=2.0, left=0.51), 2)
    assert not falls_short(_fitted(high=2.1, at_fine_end=2.0, left=0.49), 2)


def test_the_interval_of_an_order_is_students_by_hand() -> None:
    """Four points askew about a line, off by d (+, -, -, +) in ln(error) at steps of ln 2: the slope stays.

    Their residuals sum up to 4 d^2, over 2 degrees of freedom and sum (x - mean)^2 = 5 ln(2)^2: the error of the slope is
    d sqrt(2 / 5) / ln 2, and half of the interval 4.302653 times that.
    """
    d = 0.01
    fit = fit_order(LADDER[:4], [dt**2 * np.exp(s * d) for s, dt in zip((1, -1, -1, 1), LADDER, strict=False)])
    assert fit is not None
    half = 4.302653 * d * np.sqrt(2 / 5) / np.log(2)
    assert (fit.low, fit.order, fit.high) == pytest.approx((2 - half, 2.0, 2 + half), rel=1e-6)


def test_equal_errors_have_order_zero_with_an_interval_of_nothing() -> None:
    fit = fit_order(LADDER, [0.4] * len(LADDER))
    assert fit is not None
    assert (fit.order, fit.low, fit.high) == (0.0, 0.0, 0.0)
    assert falls_short(fit, 1)
