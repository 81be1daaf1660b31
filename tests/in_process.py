"""Trials of a campaign carried out and clocked in this process: for what engines answer, not for how processes end."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

from plumbline.harness.case import Case
from plumbline.harness.run import campaign
from plumbline.harness.run.timing_protocol import summarise
from plumbline.harness.store.record import Record, Sample, Timing
from plumbline.harness.study import plugins
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial import ensemble
from plumbline.harness.trial.accuracy import judged_anew, run_trial
from plumbline.harness.trial.bench import Bench
from plumbline.harness.trial.ensemble import endure

__all__ = ["barely_clocked", "clocked_by", "in_this_process", "steps_of_run"]

CANARY = 1e-3
"""Seconds of the canary in a block."""


def in_this_process(patch: pytest.MonkeyPatch, cases: Mapping[str, Case] | None = None) -> None:
    """Run the trials of whatever campaign is carried out here, until the patch is undone: what one raises, the test raises.

    Args: cases: those that are not as they are found by their names.
    """

    def answers(
        trials: Sequence[Trial], folder: Path, _workers: int, earlier: Mapping[str, Record] = MappingProxyType({})
    ) -> Iterator[Record]:
        for trial in trials:
            answer = endure if trial.members > 1 else run_trial
            case = (cases or {}).get(trial.case) or plugins.case(trial.case)
            known = earlier.get(trial.trial)
            if known is not None and (anew := judged_anew(trial, case, known, folder)) is not None:
                yield replace(anew, simulated_as=known.simulated_as or known.trial)
            else:
                yield answer(trial, case, plugins.adapter(trial.engine), folder)

    patch.setattr(campaign, "run_isolated", answers)


def clocked_by(patch: pytest.MonkeyPatch, blocks: Callable[[Trial], Sequence[float]]) -> None:
    """Let clocks say what a formula says, until the patch is undone, and never that a machine was restless.

    Args: blocks: CPU seconds of a step of a trial, block by block.
    """

    def clocks(trials: Sequence[Trial], _folder: Path, **_how: object) -> Iterator[Timing]:
        for trial in trials:
            run = steps_of_run(trial)
            samples = tuple(
                Sample(process=0, block=k, steps=run, cpu=run * step, wall=CANARY, canary=CANARY, switches=0, run=run)
                for k, step in enumerate(blocks(trial))
            )
            yield replace(summarise(trial, samples), unstable_timing=False)

    patch.setattr(campaign, "clock_group", clocks)


def steps_of_run(trial: Trial) -> int:
    """The clocked steps of a whole run."""
    case, dt = plugins.case(trial.case), trial.settings.dt
    return max(1, round(case.duration / dt) - round((case.steady or 0.0) / dt))


def barely_clocked(patch: pytest.MonkeyPatch) -> None:
    """Let the rough cost of an ensemble be that of a step, until the patch is undone: for what breaks it, not what it costs.

    The clock still has to bear the scene.
    """

    def one_step(side: Bench) -> float:
        try:
            return side.clock(1)[0] / (side.units * side.dt)
        finally:
            side.stop()

    patch.setattr(ensemble, "rough_cost", one_step)
