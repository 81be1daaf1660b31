"""Trials of a campaign carried out in this process: for what engines answer, not for how a process of theirs ends."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from harness.run import campaign
from harness.store.record import Record
from harness.study import plugins
from harness.study.trial import Trial
from harness.trial.accuracy import run_trial
from harness.trial.ensemble import endure

__all__ = ["in_this_process"]


def _answers(trials: Sequence[Trial], folder: Path, _workers: int) -> Iterator[Record]:
    for trial in trials:
        answer = endure if trial.members > 1 else run_trial
        yield answer(trial, plugins.case(trial.case), plugins.adapter(trial.engine), folder)


def in_this_process(patch: pytest.MonkeyPatch) -> None:
    """Run the trials of whatever campaign is carried out here, until the patch is undone: what one raises, the test raises."""
    patch.setattr(campaign, "run_isolated", _answers)
