"""Are changes of a history seen, at the right night, and nothing where there is none?

The rates asked for are those that the project promises where a night's price is known to 2 %. A step of 5 % is two and a half
spreads; one series alone cannot place that to the night (whoever knows that there is exactly one step does so in 51 or 52 of
60), so three that should move together are asked.
"""

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from plumbline.harness.statistics.change_points import ENDS, change_points, common_mode, levelled, one_drift
from plumbline.harness.trajectory import Floats
from tests.synthetic_nights import NIGHTS, History, history

HISTORIES = [range(0, 60, 3), pytest.param(range(60), marks=pytest.mark.slow)]
"""Each by its number: every third of sixty, or all."""


def by_series(night: History) -> Floats:
    return night.prices / common_mode(night.prices)


def by_canary(night: History) -> Floats:
    return night.prices / night.canary


def step(size: float, night: int) -> Floats:
    return np.where(np.arange(NIGHTS) >= night, 1 + size, 1.0)


def steps_placed(histories: range, size: float, together: int, free: Callable[[History], Floats]) -> int:
    placed = 0
    for number in histories:
        night, signed = 8 + number * 44 // 59, size if number % 2 else -size
        series = free(history((2, number), changed=together, factor=step(signed, night)))
        found = change_points(levelled(series[:together]) if together > 1 else series[0])
        placed += any(abs(point.index - night) <= 1 and (point.ratio > 1) == (signed > 0) for point in found)
    return placed


@pytest.mark.parametrize("histories", HISTORIES)
def test_histories_without_a_change_raise_no_alarm(histories: range) -> None:
    for free in (by_series, by_canary):
        assert not [n for n in histories if change_points(free(history((1, n)))[0])]


@pytest.mark.parametrize("histories", HISTORIES)
def test_a_step_of_ten_percent_is_placed_to_the_night_and_one_of_five_where_three_series_are_judged_together(
    histories: range,
) -> None:
    assert steps_placed(histories, 0.10, 3, by_series) == len(histories)
    assert steps_placed(histories, 0.05, 3, by_series) >= 0.95 * len(histories)
    assert steps_placed(histories, 0.10, 1, by_canary) == len(histories)


@pytest.mark.parametrize("histories", HISTORIES)
def test_a_drift_of_ten_percent_over_thirty_nights_is_seen_as_slower_and_slower(histories: range) -> None:
    for number in histories:
        drift = 1 + 0.1 * np.clip((np.arange(NIGHTS) - 5 - number % 20) / 30, 0, 1)
        found = change_points(by_series(history((3, number), factor=drift))[0])
        assert found, number
        assert all(point.ratio > 1 for point in found), number


def test_a_step_without_noise_has_its_size_and_its_night_with_and_without_gaps() -> None:
    series = 2e-3 * step(0.2, 20)
    series[[3, 19, 40]] = np.nan
    (point,) = change_points(series)
    assert point.index == 20
    assert abs(point.ratio - 1.2) < 1e-9  # rounding of logarithms and their means
    assert point.p_value < 1e-9


def test_a_new_version_opens_a_segment_and_is_no_change() -> None:
    series = step(0.5, 30)
    assert change_points(series)
    assert not change_points(series, (np.arange(NIGHTS) >= 30).astype(np.int64))


def test_a_slope_over_a_thousand_nights_is_one_and_takes_no_more_memory_than_a_short_one_does() -> None:
    nights = np.arange(1000.0)
    rising = np.exp(0.3 * np.clip((nights - 200) / 600, 0, 1))
    stairs = np.exp(0.15 * (nights >= 400) + 0.15 * (nights >= 600))
    noise = np.exp(np.random.default_rng(5).normal(0, 0.01, 1000))
    tracemalloc.start()
    assert one_drift(rising * noise, 400, 600)
    assert not one_drift(stairs * noise, 400, 600)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4 * 8 * ENDS**2 / 2 * 1000  # four arrays of a number for each night and each pair of ends


def test_too_few_nights_give_no_answer_and_nights_without_any_price_no_trouble() -> None:
    assert change_points(np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])) == ()
    assert change_points(np.full(NIGHTS, np.nan)) == ()
    empty = np.full((3, NIGHTS), np.nan)
    assert (common_mode(empty) == 1).all()
    assert np.isnan(levelled(empty)).all()
