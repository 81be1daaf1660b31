"""How much of a night's budget is set aside for its end."""

import math

import pytest

from plumbline.harness.history.budget import MARGIN, UNKNOWN, Budget, Closings
from plumbline.harness.history.plan import Plan

THREE = Closings((1155, 2910, 4248), (79.0, 98.0, 90.0), (1.0, 1.0, 1.0))
"""As three nights on two loaded cores."""


def test_the_first_night_sets_three_twentieths_aside_and_one_without_a_budget_nothing() -> None:
    none = Closings((), (), ())
    assert none.foreseen(5000, 3.0) is None
    assert Budget(900.0, 0.0, none).closing == UNKNOWN * 900
    endless = Budget(math.inf, 0.0, THREE)
    endless.set_aside(4000, 2.0)
    assert endless.end == math.inf


def test_what_is_foreseen_grows_with_what_is_stored_and_never_falls_with_it() -> None:
    rising = Closings((1000, 2000, 3000), (30.0, 50.0, 70.0), (1.0, 1.0, 1.0))
    assert rising.foreseen(4000, 1.0) == pytest.approx(90)
    assert rising.foreseen(0, 1.0) == pytest.approx(30)  # 10 by the line, and no night ended so soon
    falling = Closings((1000, 3000), (90.0, 70.0), (1.0, 1.0))
    assert falling.foreseen(9000, 1.0) == falling.foreseen(1000, 1.0) == pytest.approx(80)
    steep = Closings((1000, 1010), (10.0, 100.0), (1.0, 1.0))
    assert (steep.foreseen(2010, 1.0) or 0) == pytest.approx(55 + 55 / 1005 * 1005)


def test_a_night_that_is_twice_as_slow_sets_twice_aside_and_is_no_measure_for_the_next() -> None:
    assert THREE.foreseen(2800, 2.0) == pytest.approx(2 * (THREE.foreseen(2800, 1.0) or 0))
    loaded = Closings((1000, 1000), (50.0, 150.0), (1.0, 3.0))
    assert loaded.foreseen(1000, 1.0) == pytest.approx(50)


def test_a_budget_keeps_half_at_least_for_its_work() -> None:
    budget = Budget(900.0, 0.0, THREE)
    assert budget.closing == pytest.approx(MARGIN * 79)
    budget.set_aside(2800, 1.7)
    assert budget.closing == pytest.approx(MARGIN * 1.7 * (THREE.foreseen(2800, 1.0) or 0))
    assert budget.end == pytest.approx(900 - budget.closing)
    budget.set_aside(2800, 9.0)
    assert budget.closing == 450


def test_a_night_is_as_slow_as_what_earlier_ones_foresaw_of_it() -> None:
    plan = Plan([], {}, {})
    assert plan.slow == 1.0
    plan.promised |= {("e", "a"): 8.0, ("e", "b"): 4.0, ("e", "under way"): 100.0}
    plan.taken |= {("e", "a"): 20.0, ("e", "new"): 500.0}
    assert plan.slow == 1.0  # eight seconds tell nothing
    plan.taken["e", "b"] = 10.0
    assert plan.slow == pytest.approx(30 / 12)
    plan.taken |= {("e", "a"): 1.0, ("e", "b"): 1.0}
    assert plan.slow == 1.0
