"""How many settings a sweep tries of each engine in a case: a small sweep, in this process, of engines as they are."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.findings.cost_point import ALIKE
from plumbline.harness.search.front import next_trials
from plumbline.harness.store.record import Record
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import run_trial

__all__ = ["Tried", "swept", "unequal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tried:
    """What was tried of a case on an engine. Terms: settings: whose answers differ; trials: all that ran."""

    case: str
    engine: str
    settings: int
    trials: int


def swept(case: Case, engines: Mapping[str, Adapter], steps: Sequence[float], sweep: int, folder: Path) -> list[Tried]:
    """The sweep of a case on each engine, from both tracks at these time steps [s], with so many points beyond."""
    experiment = Experiment(name="knobs", dt=tuple(steps), sweep=sweep, timing=False)
    study = Study(name="knobs", recordings=False, experiments=(experiment,))
    cases = {case.name: case}
    trials = list(study.trials(cases, engines, dict.fromkeys(engines, "1")))
    records = {trial.trial: _run(trial, case, engines[trial.engine], folder) for trial in trials}
    while more := next_trials(trials, records, cases, engines):
        records |= {trial.trial: _run(trial, case, engines[trial.engine], folder) for trial in more}
        trials += more
    found = []
    for name in engines:
        mine = [records[trial.trial] for trial in trials if trial.engine == name]
        answers = {record.trajectory_hash for record in mine if record.trajectory_hash is not None}
        found.append(Tried(case=case.name, engine=name, settings=len(answers), trials=len(mine)))
    return found


def _run(trial: Trial, case: Case, adapter: Adapter, folder: Path) -> Record:
    start = time.process_time()
    record = run_trial(trial, case, adapter, folder)
    return replace(record, rough_cost=(time.process_time() - start) / case.duration)


def unequal(tried: Sequence[Tried]) -> list[str]:
    """Of a case, the engines of which another has more than `ALIKE` times the settings, each in words."""
    most = max(tried, key=lambda one: one.settings)
    return [
        f"{one.case}: {one.settings} settings of {one.engine}, {most.settings} of {most.engine}"
        for one in tried
        if most.settings > ALIKE * one.settings
    ]
