"""Trials of a campaign carried out in this process: for what engines answer, not for how a process of theirs ends."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pytest

from harness.case import Case
from harness.run import campaign
from harness.store.record import Record
from harness.study import plugins
from harness.study.trial import Trial
from harness.trial.accuracy import run_trial
from harness.trial.ensemble import endure

__all__ = ["in_this_process"]


def in_this_process(patch: pytest.MonkeyPatch, cases: Mapping[str, Case] | None = None) -> None:
    """Run the trials of whatever campaign is carried out here, until the patch is undone: what one raises, the test raises.

    Args: cases: those that are not as they are found by their names.
    """

    def answers(trials: Sequence[Trial], folder: Path, _workers: int) -> Iterator[Record]:
        for trial in trials:
            answer = endure if trial.members > 1 else run_trial
            case = (cases or {}).get(trial.case) or plugins.case(trial.case)
            yield answer(trial, case, plugins.adapter(trial.engine), folder)

    patch.setattr(campaign, "run_isolated", answers)
