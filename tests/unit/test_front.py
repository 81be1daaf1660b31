"""The Pareto front and the price between two answers, against counting by hand and against a power law."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbline.harness.statistics.pareto import near_front, on_front, price

NUMBERS = st.floats(min_value=1e-9, max_value=1e9)


def test_the_front_by_hand() -> None:
    """Cheaper and worse, dearer and better are both on it; what is dearer and worse, or a second of equals, is not."""
    error = [1.0, 0.1, 0.1, 0.5, 0.1]
    cost = [1.0, 10.0, 20.0, 11.0, 10.0]
    assert on_front(error, cost).tolist() == [True, True, False, False, False]
    assert near_front(error, cost).tolist() == [True, True, False, False, True]
    assert near_front(error, cost, 1.5).tolist() == [True, True, False, True, True]


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=12))
def test_a_point_is_on_the_front_unless_another_beats_it(points: list[tuple[float, float]]) -> None:
    """Every point left out has one on the front that is no worse in both; no two on the front are comparable."""
    error, cost = [e for e, _ in points], [c for _, c in points]
    front = [point for point, on in zip(points, on_front(error, cost), strict=True) if on]
    assert all(any(e <= mine[0] and c <= mine[1] for e, c in front) for mine in points)
    assert all((a[0] < b[0]) != (a[1] < b[1]) for k, a in enumerate(front) for b in front[:k])


@given(st.floats(min_value=0.5, max_value=8.0), st.floats(min_value=1e-7, max_value=1e-1))
def test_a_power_law_is_priced_exactly(order: float, wanted: float) -> None:
    """error = dt^order, cost = 1/dt: an error e costs e^(-1/order), within rounding of the logarithms."""
    dt = np.geomspace(1e-15, 1.0, 40)
    found = price(dt**order, 1 / dt, np.array([wanted]))
    assert found[0] == pytest.approx(wanted ** (-1 / order), rel=1e-9)


def test_ends_of_a_ladder() -> None:
    """Coarser than the cheapest answer costs what that does; finer than the best has no price."""
    found = price(np.array([1e-2, 1e-3]), np.array([1.0, 4.0]), np.array([1.0, 1e-3, 9.9e-4]))
    assert found[:2] == pytest.approx([1.0, 4.0])
    assert np.isnan(found[2])


def test_a_better_answer_that_is_cheaper_serves_coarser_targets_too() -> None:
    """As drawn costs may be: nobody would buy the worse one."""
    found = price(np.array([1e-1, 1e-2]), np.array([5.0, 2.0]), np.array([0.5, 0.05]))
    assert found == pytest.approx([2.0, 2.0])
