"""The time that a run still takes: ladders and clocks whose truth is known."""

from dataclasses import dataclass
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest

from plumbline.harness.case.alteration import AS_IT_IS
from plumbline.harness.run.progress import in_words
from plumbline.harness.run.remaining_time import RemainingTime
from plumbline.harness.study.experiment import Experiment, Limit

_RUN = SimpleNamespace(duration=1.0, rays=None)
CASES: Any = {name: SimpleNamespace(put=lambda _: _RUN, rays=None) for name in "xyz"}
PLAIN = Experiment(name="plain", timing=False)


@dataclass(frozen=True)
class Trial:
    """What the time of a trial depends on. Terms: dt [s]."""

    trial: str
    case: str
    engine: str
    dt: float = 0.01
    experiment: Experiment = PLAIN
    members: int = 1
    parameters: str = ""

    @property
    def settings(self) -> Any:
        """Its step."""
        return SimpleNamespace(dt=self.dt, substeps=None)

    alteration = AS_IT_IS


def record(name: str, status: str = "passed", rough_cost: float = 0.0) -> Any:
    return SimpleNamespace(trial=name, status=status, rough_cost=rough_cost)


def expecting(trials: Any, workers: int = 1) -> RemainingTime:
    remaining = RemainingTime(CASES, workers)
    remaining.expect(trials)
    remaining.answers_begin([trial.trial for trial in trials], 0.0)
    return remaining


@pytest.mark.parametrize("workers", [1, 2])
def test_along_a_ladder_it_grows_with_the_number_of_steps(workers: int) -> None:
    """Three engines with rates of their own, coarse to fine: by the mean of the past the end would be a surprise."""
    rates = {"a": 1e-3, "b": 4e-3, "c": 2e-4}
    trials = [Trial(f"{e}{k}", "x", e, 0.01 / 2**k) for k, e in product(range(8), rates)]
    free, ends = [0.0] * workers, []
    for trial in trials:
        begin = free.pop(free.index(min(free)))
        free.append(begin + 0.3 + rates[trial.engine] / trial.dt)
        ends.append((free[-1], trial.trial))
    remaining: Any = expecting(trials, workers)
    whole, count = max(free), 0
    for end, name in sorted(ends):
        remaining.answered(record(name), end)
        left = remaining.left()
        if left is not None and 0.1 * whole < end < 0.9 * whole:
            count += 1
            assert 1 / 2 < left[1] / (whole - end) < 2
            assert left[0] <= left[1]
    assert count >= 5


def test_the_first_answer_of_an_engine_is_not_taken_for_the_others() -> None:
    trials = [Trial(str(k), "x", "e") for k in range(46)]
    remaining: Any = expecting(trials)
    remaining.answered(record("0"), 60.0)  # it compiled
    for k in range(1, 6):
        remaining.answered(record(str(k)), 60.0 + k)
    assert remaining.left() == pytest.approx((40.0, 40.0))


def test_the_range_is_the_middle_half_of_what_answers_took_over_what_was_foreseen() -> None:
    """Foreseen by the mean of those before: answers of 0.5, 1.5, 1 and 1 s after one of 1 s, of means 1, 0.75, 1 and 1."""
    remaining: Any = expecting([Trial(str(k), "x", "e") for k in range(16)])
    now = 0.0
    for k, seconds in enumerate((9.0, 1.0, 0.5, 1.5, 1.0, 1.0)):
        now += seconds
        remaining.answered(record(str(k)), now)
    low, high = remaining.left()
    assert (low, high) == pytest.approx((10 * 0.875, 10 * 1.25))


def test_nothing_is_said_before_four_answers_were_foreseen() -> None:
    remaining: Any = expecting([Trial(str(k), "x", "e") for k in range(9)])
    for k in range(5):
        remaining.answered(record(str(k)), 1.0 + k)
        assert remaining.left() is None
    remaining.answered(record("5"), 6.0)
    assert remaining.left() is not None


def test_what_has_an_answer_or_failed_to_run_is_not_counted() -> None:
    clocked = Experiment(name="clocked", samples=3, processes=1, sample_seconds=1.0)
    remaining: Any = expecting([Trial(str(k), "x", "e", experiment=clocked) for k in range(9)])
    for k in range(6):
        remaining.answered(record(str(k), "crashed"), 1.0 + k)
    remaining.forget(["6", "7", "8"])
    assert remaining.left()[0] == pytest.approx(3 * 3.1)  # Three samples and a start of each that may still be clocked.
    remaining.clocks_begin([], {}, 6.0)
    assert remaining.left() == (0.0, 0.0)


def test_with_the_first_timing_of_a_sitting_all_of_it_is_done_and_the_pace_of_the_clock_is_known() -> None:
    clocked = Experiment(name="clocked", samples=3, processes=1, sample_seconds=1.0)
    trials = [Trial(f"{case}{k}", case, "e", experiment=clocked) for case in "xy" for k in range(3)]
    remaining: Any = expecting(trials)
    for k, trial in enumerate(trials):
        remaining.answered(record(trial.trial), 1.0 + k)
    remaining.clocks_begin(trials, {trial.trial: record(trial.trial) for trial in trials}, 6.0)
    assert remaining.left()[0] == pytest.approx(6 * 3.1)
    remaining.clocked(trials[:3], 26.0)  # Twenty seconds for three trials.
    first = remaining.left()
    assert first[0] == pytest.approx(20.0)
    remaining.clocked(trials[:3], 26.0)
    assert remaining.left() == first


def test_a_search_counts_as_one_more_round() -> None:
    sought = Experiment(name="sought", timing=False, limit=Limit())
    plain, searched = (
        expecting([Trial(str(k), "x", "e", experiment=experiment) for k in range(10)]) for experiment in (PLAIN, sought)
    )
    for k in range(6):
        for remaining in (plain, searched):
            remaining.answered(record(str(k)), 1.0 + k)
    assert plain.left() == pytest.approx((4.0, 4.0))
    assert searched.left() == pytest.approx((14.0, 14.0))


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.0, 0.0, "about 0 s left"),
        (20.2, 47.3, "about 20 to 47 s left"),
        (47.1, 47.3, "about 47 s left"),
        (40.0, 119.6, "about 40 to 120 s left"),
        (63.0, 130.0, "about 1.1 to 2.2 min left"),
        (1500.0, 3025.0, "about 25 to 50 min left"),
        (4000.0, 9000.0, "about 1.1 to 2.5 h left"),
    ],
)
def test_an_estimate_has_two_digits(low: float, high: float, text: str) -> None:
    assert in_words(low, high) == text
