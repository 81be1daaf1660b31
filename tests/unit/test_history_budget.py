"""How much of a night's budget is set aside for its end."""

import math

import pytest

from plumbline.harness.history.blocks import Plan
from plumbline.harness.history.budget import CLOSING, MARGIN, UNKNOWN, Budget

THREE = ((1155, 79.0), (2910, 98.0), (4248, 90.0))
"""As three nights on two loaded cores."""


def test_the_first_night_sets_three_twentieths_aside_and_one_without_a_budget_nothing() -> None:
    assert Budget(900.0, 0.0).closing == UNKNOWN * 900
    endless = Budget(math.inf, 0.0, THREE)
    endless.set_aside(4000, 2.0)
    assert endless.end == math.inf


@pytest.mark.parametrize(("answers", "due"), [(0, 98.0), (1155, 98.0), (2910, 79.0 * 2910 / 1155), (4248, 79.0 * 4248 / 1155)])
def test_as_long_as_the_longest_of_the_last_ends_is_set_aside_and_more_where_there_are_more_answers(
    answers: int, due: float
) -> None:
    budget = Budget(3600.0, 0.0, THREE)
    assert budget.closing == CLOSING * 3600
    budget.set_aside(answers, 1.0)
    assert budget.closing == pytest.approx(max(MARGIN * due, CLOSING * 3600))
    budget.set_aside(answers, 4.0)
    assert budget.closing == pytest.approx(4 * MARGIN * due)


def test_a_night_that_was_slow_is_no_measure_for_the_next() -> None:
    slow, plain = ({"answers": 1000, "seconds": {"closing": took, "slow": slow}} for took, slow in ((150.0, 3.0), (50.0, 1.0)))
    assert Budget.of(900.0, [slow]).closings == Budget.of(900.0, [plain]).closings == ((1000, 50.0),)


def test_a_budget_keeps_half_at_least_for_its_work() -> None:
    budget = Budget(900.0, 0.0, THREE)
    budget.set_aside(2800, 1.7)
    assert budget.end == pytest.approx(900 - budget.closing)
    budget.set_aside(2800, 9.0)
    assert budget.closing == 450


def test_a_night_is_as_slow_as_what_earlier_ones_foresaw_of_it() -> None:
    plan = Plan((), {}, {})
    assert plan.slow == 1.0
    plan.promised |= {("e", "a"): 8.0, ("e", "b"): 4.0, ("e", "under way"): 100.0}
    plan.taken |= {("e", "a"): 20.0, ("e", "new"): 500.0}
    assert plan.slow == 1.0  # eight seconds tell nothing
    plan.taken["e", "b"] = 10.0
    assert plan.slow == pytest.approx(30 / 12)
    plan.taken |= {("e", "a"): 1.0, ("e", "b"): 1.0}
    assert plan.slow == 1.0
