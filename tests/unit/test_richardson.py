"""Richardson limits, ladders that converge or do not, and camps: by closed form and by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.findings.agreement.judgement import camps
from plumbline.harness.statistics.richardson import (
    Convergence,
    convergence,
    extrapolate,
    horizon,
    limit,
    observed_order,
    slopes,
)
from plumbline.harness.statistics.student import mean_of

TIME = np.arange(101) / 50
STEPS = [1 / 240 / 2**k for k in range(5)]
RATES = [1 / step for step in STEPS]
NONE = np.zeros(len(TIME))
TOLERANCE = 0.01


def size(values: np.ndarray) -> np.ndarray:
    return np.abs(values).reshape(len(values), -1).max(axis=1)


def runs(error: "list[np.ndarray]") -> list[np.ndarray]:
    """Of a true answer sin t, with errors that are told run by run."""
    return [np.sin(TIME) + each for each in error]


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_limit_knows_its_order_and_its_bar_holds_the_truth(order: int) -> None:
    """f = sin t + 30 t h^p + 200 t h^(p+1): the second term is what an extrapolation leaves."""
    made = runs([30 * TIME * step**order + 200 * TIME * step ** (order + 1) for step in STEPS])
    found = limit(made, RATES, NONE, size)
    error = np.abs(found.value - np.sin(TIME))
    assert (found.order[1:] == order).all()
    assert (error <= found.bar + 1e-15).all()
    # It is sharp: nearer to the truth than the finest run by far, and its bar says so.
    assert found.bar[-1] < 0.1 * np.abs(made[-1] - np.sin(TIME)).max()


def test_where_no_order_shows_the_finest_run_stands_with_a_bar_of_three_differences() -> None:
    made = runs([sign * 5 * TIME * step for sign, step in zip((1, -1, 1, -1, 1), STEPS, strict=True)])
    found = limit(made, RATES, NONE, size)
    assert not found.order[1:].any()  # at the start all are equal
    assert (np.abs(found.value - np.sin(TIME)) <= found.bar).all()
    # Of the last four, differences are 5 t (h_i + h_(i+1)), each brought to the finest step.
    differences = [5 * 2.0 * (STEPS[i] + STEPS[i + 1]) * STEPS[-1] / STEPS[i + 1] for i in (1, 2, 3)]
    assert found.bar[-1] == pytest.approx(3 * max(differences), rel=1e-12)


def test_orders_may_change_on_the_way_and_bars_never_shrink() -> None:
    """Second order up to t = 1, an error of the first with either sign from there on, as after an impact."""
    late = np.where(TIME > 1.0, TIME - 1.0, 0.0)
    signs = (1.0, -0.4, 0.9, -0.7, 0.3)
    made = runs([9 * TIME * step**2 + sign * 3 * late * step for sign, step in zip(signs, STEPS, strict=True)])
    found = limit(made, RATES, NONE, size)
    assert (found.order[1:50] == 2).all()
    assert found.order[-1] == 0
    assert (np.diff(found.bar) >= 0).all()
    assert (np.abs(found.value - np.sin(TIME)) <= found.bar + 1e-15).all()


def test_three_runs_give_a_limit_with_the_wider_factor_and_two_give_none() -> None:
    """The error of f = 1 + h + h^2 extrapolated from h and h/2 is -h^2/2, by hand."""
    made = [np.array([1 + h + h * h]) for h in (0.04, 0.02, 0.01)]
    three = extrapolate(made, [25, 50, 100], 0.0)
    assert three.value[0] == pytest.approx(1 - 0.02 * 0.01, rel=1e-12)
    left = abs((1 - 0.02 * 0.01) - (1 - 0.04 * 0.02))
    assert three.error == pytest.approx(3 * left, rel=1e-9)
    two = extrapolate(made[1:], [50, 100], 0.0)
    assert two.value[0] == made[-1][0]
    assert math.isnan(two.order)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_an_order_is_read_off_two_differences(order: float) -> None:
    n = np.array([240.0, 480.0, 960.0])
    ratio = (n[0] ** -order - n[1] ** -order) / (n[1] ** -order - n[2] ** -order)
    assert observed_order(ratio, n.tolist()) == pytest.approx(order, abs=1e-3)


def told(apart: np.ndarray, bar: np.ndarray | None = None) -> Convergence:
    return convergence(TIME, STEPS, apart, 3 * np.maximum.accumulate(apart[-1]) if bar is None else bar, TOLERANCE)


def test_a_ladder_of_the_first_order_converges_to_the_end() -> None:
    said = told(np.array([TIME * step for step in STEPS[:-1]]))
    assert said.until == TIME[-1]
    assert said.ended == "end"
    assert said.order == pytest.approx(1.0)
    assert said.regular == 1.0


def test_a_ladder_that_ends_elsewhere_at_each_step_draws_together_nowhere() -> None:
    said = told(np.array([factor * TIME**2 for factor in (0.3, 0.2, 0.25, 0.35)]))
    assert said.ended == "no shrinking"
    # Up to a tenth of the tolerance it may be a floor: 0.35 t^2 = 0.001 at t = 0.053.
    assert said.until == pytest.approx(0.04)
    assert said.regular < 0.5


def test_a_floor_below_a_tenth_of_the_tolerance_need_not_shrink() -> None:
    low = told(np.array([np.minimum(TIME, 1.0) * level for level in (9e-4, 8e-4, 9e-4, 9e-4)]))
    assert low.ended == "end"
    assert low.order is None
    high = told(np.array([np.minimum(TIME, 1.0) * level for level in (3e-3, 2e-3, 2.5e-3, 3e-3)]))
    assert high.ended == "no shrinking"


def test_chaos_ends_the_horizon_and_every_halving_puts_it_off_by_the_same_time() -> None:
    """Differences h e^(L t), saturated at the size: a halving delays the crossing of the tolerance by ln 2 / L, 0.087 s."""
    growth = 8.0
    parted = np.array([np.minimum(step * np.exp(growth * TIME) * 0.01, 1.0) for step in STEPS[:-1]])
    ends = [horizon(TIME, np.maximum.accumulate(each), TOLERANCE) for each in parted]
    gaps = np.diff(ends)
    assert gaps == pytest.approx(np.full(3, math.log(2) / growth), abs=0.02)
    said = told(parted)
    assert said.ended == "horizon"
    assert 0 < said.until <= said.horizon == ends[-1]


def test_what_is_not_a_number_is_beyond_every_horizon() -> None:
    parted = np.array([TIME * step for step in STEPS[:-1]])
    parted[-1, 30:] = np.nan
    said = told(parted, np.full(len(TIME), 1e-6))
    assert said.until == TIME[29]
    assert said.horizon == TIME[29]


def test_slopes_are_those_of_a_straight_line() -> None:
    moved = np.array([[step**1.5, step**3] for step in STEPS])
    assert slopes(STEPS, moved) == pytest.approx([1.5, 3.0])


def agreeing(places: list[float], bars: list[float]) -> np.ndarray:
    x, b = np.array(places), np.array(bars)
    return np.abs(x[:, None] - x) <= b[:, None] + b


def test_two_against_two_are_two_camps() -> None:
    places, bars = [0.0, 0.001, 1.0, 1.001], [0.001] * 4
    assert camps(agreeing(places, bars), bars) == [(0,), (0,), (1,), (1,)]


def test_agreement_is_not_passed_on_and_a_wide_bar_is_undecided() -> None:
    """The middle one agrees with both, which differ: it founds no bridge between them."""
    places, bars = [0.0, 0.5, 1.0], [0.01, 0.6, 0.01]
    assert camps(agreeing(places, bars), bars) == [(0,), (0, 1), (1,)]


def test_one_alone_is_a_camp_and_none_are_none() -> None:
    assert camps(np.ones((1, 1), bool), [0.1]) == [(0,)]
    assert camps(np.ones((0, 0), bool), []) == []


def test_a_mean_has_students_interval() -> None:
    """Of 1..5: s = sqrt(2.5), and t at 99 % with 4 degrees of freedom is 4.604 (Student's table)."""
    found = mean_of([1.0, 2.0, 3.0, 4.0, 5.0])
    assert found.value == 3.0
    assert found.half == pytest.approx(4.604 * math.sqrt(2.5 / 5), rel=1e-3)
    assert mean_of([2.0]).half == math.inf
    assert math.isnan(mean_of([1.0, math.nan]).value)
