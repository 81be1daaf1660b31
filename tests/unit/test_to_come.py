"""What searches will still ask for, against what they then ask for: on an engine whose limit is planted."""

import math

import numpy as np
import pytest

from harness.search.first_break import next_trials
from harness.search.to_come import to_come
from harness.store.record import Record
from harness.study.experiment import Experiment, Limit
from harness.study.study import Study
from harness.study.trial import Trial
from harness.trial.ensemble import endure
from tests.unit.test_limits import EASY, EXTREME, BrittleEngine, case_of

CASE = case_of()


def foreseen_and_asked(limit: float, search: Limit) -> list[tuple[float, int]]:
    """Before each round: answers that were foreseen beyond it, and that came."""
    engine = BrittleEngine(limit=limit)
    experiment = Experiment(name="axis", tracks=("tuned",), timing=False, limit=search)
    cases, adapters = {CASE.name: CASE}, {engine.name: engine}
    trials = list(Study(name="limits", experiments=(experiment,)).trials(cases, adapters, {engine.name: "1"}))
    records: dict[str, Record] = {}
    looks: list[tuple[float, int]] = []
    more: list[Trial] = trials
    while more:
        expected = sum(each.answers for each in to_come(trials, records, cases, adapters))
        looks.append((expected, len(trials)))
        records |= {trial.trial: endure(trial, CASE, engine, None) for trial in more}
        more = next_trials(trials, records, cases, adapters)
        trials = [*trials, *more]
    assert sum(each.answers for each in to_come(trials, records, cases, adapters)) == 0.0
    return [(expected, len(trials) - known) for expected, known in looks]


@pytest.mark.parametrize("seed", range(5))
def test_once_a_value_broke_every_bisection_to_come_is_foreseen(seed: int) -> None:
    limit = math.exp(np.random.default_rng(seed).uniform(math.log(2 * EASY), math.log(EXTREME / 2)))
    looks = foreseen_and_asked(limit, Limit(within=1.1))
    # Of a bracket of a third of four decades, halved until its ends are within a tenth, the last five are always among these.
    for expected, asked in looks[-5:]:
        assert expected == pytest.approx(asked, abs=1.0)


def test_before_anything_broke_it_lies_between_a_scan_and_a_scan_with_all_bisections() -> None:
    """Four values from easy to extreme; log2(log(10^(4/3)) / log(1.1)) = 5.01, so that six bisections follow a break."""
    expected, _ = foreseen_and_asked(30.0, Limit(within=1.1))[0]
    assert 3 < expected < 3 + 6


def test_an_engine_that_never_breaks_is_done_with_its_scan() -> None:
    looks = foreseen_and_asked(2 * EXTREME, Limit(within=1.1))
    assert [asked for _, asked in looks] == [3, 2, 1, 0]
    assert looks[-1][0] < 6


def test_remedies_are_foreseen_where_a_case_is_about_to_break() -> None:
    plain, with_remedies = (foreseen_and_asked(30.0, Limit(within=1.1, remedies=tracks)) for tracks in ((), ("tuned",)))
    assert with_remedies[0][0] > plain[0][0] + 1


def test_nothing_is_to_come_of_a_study_without_searches() -> None:
    engine = BrittleEngine(limit=1.0)
    study = Study(name="plain", experiments=(Experiment(name="look", tracks=("tuned",), timing=False),))
    trials = list(study.trials({CASE.name: CASE}, {engine.name: engine}, {engine.name: "1"}))
    assert to_come(trials, {}, {CASE.name: CASE}, {engine.name: engine}) == []
