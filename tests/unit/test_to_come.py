"""What searches will still ask for, against what they then ask for: on an engine whose limit is planted."""

import math

import numpy as np
import pytest

from harness.search.first_break import next_trials
from harness.search.front import PER_ROUND, SCREENING
from harness.search.to_come import to_come
from harness.store.record import Record
from harness.study.experiment import Experiment, Limit, Refinement
from harness.study.study import Study
from harness.study.trial import Trial
from harness.trial.ensemble import endure
from tests.unit import test_refined_ladder as ladders
from tests.unit import test_sweep as sweeps
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


@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 5))])
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


@pytest.mark.parametrize(("budget", "halvings"), [(4.0, 0), (8.0, 1), (16.0, 2)])
def test_a_ladder_is_foreseen_down_to_its_finest_step_or_to_the_end_of_its_budget(budget: float, halvings: int) -> None:
    """Two engines on two tracks share the budget; a run costs .1 s at the first of three steps, twice that at the next."""
    trials, records = ladders.carried_out(dict.fromkeys("ab", ladders.first_order), Refinement(budget=budget))
    begun = [trial for trial in trials if trial.round == 0]
    known = {trial.trial: records[trial.trial] for trial in begun}
    sure = [each for each in to_come(begun, known, {ladders.CASE.name: ladders.CASE}, {}) if each.answers == 1.0]
    asked = [trial for trial in trials if trial.round > 0]
    assert len(asked) == 4 * halvings
    assert sorted(each.like.settings.dt for each in sure) == pytest.approx(sorted(trial.settings.dt for trial in asked))
    for each in sure:
        assert each.run == pytest.approx(0.5 * 0.1 / 240 / each.like.settings.dt)
        assert each.clocks == 0.0


def test_a_ladder_that_others_went_on_from_is_over() -> None:
    """Ladders are halved side by side: one that has no trial in the newest round, and waits for none, was not halved."""
    trials, records = ladders.carried_out(dict.fromkeys("ab", ladders.first_order), Refinement(budget=1e6, members=0))
    newest = max(trial.round for trial in trials)
    before = [trial for trial in trials if trial.round < newest]
    left_behind = [trial for trial in trials if trial.round < newest or trial.engine == "b"]

    def engines(here: list[Trial]) -> set[str]:
        return {each.like.engine for each in to_come(here, records, {ladders.CASE.name: ladders.CASE}, {}) if each.answers}

    assert engines(before) == {"a", "b"}
    assert "a" not in engines(left_behind)


def test_a_sweep_that_finds_less_than_a_round_may_hold_runs_dry() -> None:
    trials, records = sweeps.unfolded(sweep=10_000)
    adapters, cases = {"made": sweeps.Made()}, {sweeps.CASE.name: sweeps.CASE}
    last = max(trial.round for trial in trials)
    late = [trial for trial in trials if trial.round == last]
    assert last > SCREENING
    assert len(late) == PER_ROUND

    def foreseen(found: int) -> float:
        here = [trial for trial in trials if trial.round < last] + late[:found]
        return sum(each.answers for each in to_come(here, records, cases, adapters))

    assert foreseen(PER_ROUND) > 1000
    assert [foreseen(found) for found in (1, 2, 3)] == [2.0, 4.0, 6.0]
