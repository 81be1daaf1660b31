"""How a study is shared out among machines: every trial in one part, and what is clocked side by side in the same."""

import dataclasses

import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.run.campaign import share
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial

PLAIN, SWEEPING = Experiment(name="plain", timing=False), Experiment(name="front", sweep=5)
CLOCKED = Experiment(name="clocked")


def trials() -> list[Trial]:
    """Five cases on three engines, swept and not."""
    one = Trial(
        trial="",
        study="s",
        experiment=PLAIN,
        case="",
        parameters={},
        engine="",
        engine_version="1",
        track="tuned",
        settings=Settings(),
        seed=0,
    )
    return [
        dataclasses.replace(one, trial=f"{experiment.name} {case} {engine}", experiment=experiment, case=case, engine=engine)
        for experiment in (PLAIN, CLOCKED, SWEEPING)
        for case in "abcde"
        for engine in ("x", "y", "z")
    ]


def test_parts_hold_every_trial_once() -> None:
    for parts in (1, 2, 3, 7):
        found = [trial.trial for part in range(1, parts + 1) for trial in share(trials(), (part, parts))]
        assert sorted(found) == sorted(trial.trial for trial in trials())


@pytest.mark.parametrize("experiment", [CLOCKED, SWEEPING], ids=lambda experiment: experiment.name)
def test_a_case_that_is_clocked_stays_whole(experiment: Experiment) -> None:
    """Its engines are compared within blocks of samples, so they have to be clocked on one machine."""
    for part in range(1, 4):
        mine = [trial for trial in share(trials(), (part, 3)) if trial.experiment == experiment]
        assert mine
        assert len(mine) == 3 * len({trial.case for trial in mine})


def test_plain_trials_are_dealt_out_evenly() -> None:
    sizes = [sum(trial.experiment == PLAIN for trial in share(trials(), (part, 4))) for part in range(1, 5)]
    assert max(sizes) - min(sizes) <= 1
