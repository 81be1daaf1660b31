"""A run with a budget of waiting time: what comes first, when it is looked at, and what is left out when the time is gone."""

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from plumbline.harness.case.alteration import AS_IT_IS, TURNED, Alteration
from plumbline.harness.run import waiting_time
from plumbline.harness.run.timing_protocol import START, clock_time
from plumbline.harness.run.waiting_time import Waiting
from plumbline.harness.study.experiment import Experiment, Refinement

LADDER = Experiment(name="ladder", refine=Refinement(), samples=3, sample_seconds=1.0)
EFFECTS = Experiment(name="effects", effects=True, samples=3, sample_seconds=1.0)
CASES: Any = {"x": SimpleNamespace(put=lambda _: SimpleNamespace(duration=1.0), rays=None)}


@dataclass(frozen=True)
class Trial:
    trial: str
    experiment: Experiment = LADDER
    dt: float = 0.01
    case: str = "x"
    parameters: str = ""
    alteration: Alteration = AS_IT_IS

    @property
    def settings(self) -> Any:
        return SimpleNamespace(dt=self.dt)


def record(name: str, rough_cost: float = 0.0) -> Any:
    return SimpleNamespace(trial=name, rough_cost=rough_cost)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr(waiting_time, "time", SimpleNamespace(monotonic=lambda: now[0]))
    return now


def test_ladders_are_answered_first_and_looked_at_once_all_first_steps_are(clock: list[float]) -> None:
    looks: list[list[str]] = []
    guide = Waiting(112.0, CASES, lambda records: looks.append([each.trial for each in records]))
    trials: Any = [Trial("e", EFFECTS), Trial("a"), Trial("b")]
    first, rest = guide.batches(trials)
    assert [trial.trial for trial in first] == ["a", "b"]
    assert [trial.trial for trial in rest] == ["e"]
    assert guide.end() == 100.0
    for trial in trials:  # of an engine that is not there nobody asks
        assert guide.known(trial) is None
    assert guide.answered(trials[0], record("e")).trial == "e"
    assert guide.end() == math.inf
    guide.answered(trials[1], record("a"))
    assert looks == []
    guide.answered(trials[2], record("b"))
    guide.answered(trials[2], record("b"))
    assert looks == [["a", "b"]]
    assert guide.end() == 100.0


def test_ladders_are_refined_for_two_fifths_of_the_time_and_causes_begin_until_half_is_gone(clock: list[float]) -> None:
    guide = Waiting(112.0, CASES, print)
    finer: Any = Trial("a")
    turned: Any = Trial("b", alteration=Alteration(name=TURNED))
    for now, allowed in ((39.0, (True, True)), (41.0, (False, True)), (51.0, (False, False))):
        clock[0] = now
        assert (guide.searches(finer, {}), guide.searches(turned, {})) == allowed


def test_what_fits_is_clocked_coarse_steps_first(clock: list[float]) -> None:
    """Three samples of a second and a start are 3.3 s each; from 70 s to 80 s three of them fit, and beyond no ladder does."""
    guide = Waiting(112.0, CASES, print)
    trials: Any = [Trial(str(k), dt=0.01 / 2**k) for k in range(6)]
    records = {trial.trial: record(trial.trial) for trial in trials}
    assert clock_time(trials[0], records["0"], CASES["x"]) == pytest.approx(3.0 + START)
    clock[0] = 70.0
    assert list(guide.clocks(list(reversed(trials)), records)) == ["0", "1", "2"]
    clock[0] = 81.0
    assert list(guide.clocks(trials, records)) == []
    effects: Any = [Trial("e", EFFECTS)]
    assert list(guide.clocks(effects, {"e": record("e")})) == ["e"]


def test_a_quarter_of_a_short_budget_is_kept_for_the_report_and_twelve_seconds_of_a_longer_one(clock: list[float]) -> None:
    """Tables and pages of a scene took 12 s after a budget was over: a person who waits two minutes has them by then."""
    assert [Waiting(budget, CASES, print).end() for budget in (10.0, 48.0, 120.0, 600.0)] == [7.5, 36.0, 108.0, 588.0]


def test_what_nobody_waited_for_is_no_part_of_the_run(clock: list[float]) -> None:
    guide = Waiting(112.0, CASES, print)
    assert list(guide.asked(["a", "b"], {"a": record("a")})) == ["a", "b"]
    guide.broken_off(())
    assert guide.over
    assert list(guide.asked(["a", "b"], {"a": record("a")})) == ["a"]


def test_a_clock_takes_few_samples_of_long_runs() -> None:
    """Half of 40 s are steps: a run of 20 s is more than ten samples of a second, so that three are taken."""
    slow: Any = Trial("a", Experiment(name="l", refine=Refinement(), samples=9, sample_seconds=1.0))
    assert clock_time(slow, record("a", 40.0), CASES["x"]) == pytest.approx(START + 3 * 20.0)


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (200.0, "3 min 20 s"), (3900.0, "1 h 5 min")]
)
def test_elapsed_time_is_said_in_two_units_at_most(seconds: float, text: str) -> None:
    assert waiting_time.elapsed(seconds) == text


def test_a_plain_line_counts_and_says_the_time_since_the_start(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(waiting_time, "_BEGUN", waiting_time.time.monotonic() - 75.0)
    with waiting_time.Progress("accuracy", 2) as bar:
        bar.advance("first")
        bar.advance("second")
    assert capsys.readouterr().err == "accuracy: 2 of 2, 1 min 15 s (second)\n"
