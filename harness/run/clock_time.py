"""How long a timing run is going to take, by what answers took: for sittings of the clock, and for a budget of waiting time."""

from plumbline.harness.case import Case
from plumbline.harness.store.record import Record
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import FEW, LONG

START = 0.1
"""Seconds that a trial takes of the start of a process, and to be ready in it."""
STEPS = 0.5
"""Of what a run of a refined ladder takes, the share of its steps; the rest is judging them."""


def seconds_of_run(trial: Trial, record: Record, case: Case) -> float:
    """What the steps of a run take, of CPU time and roughly; 0 if that is not known or what is clocked is no step."""
    share = 1.0 if trial.experiment.refine is None else STEPS
    return share * (record.rough_cost or 0.0) * case.put(trial.parameters).duration if case.rays is None else 0.0


def clock_time(trial: Trial, record: Record, case: Case) -> float:
    """Of a timing run [s]: its share of each start, and samples that take a run each if that is longer; few of long runs."""
    experiment, run = trial.experiment, seconds_of_run(trial, record, case)
    count = experiment.processes * experiment.samples
    if run > LONG * experiment.sample_seconds:
        count = min(count, FEW)
    return experiment.processes * START + count * max(experiment.sample_seconds, run)


def together(trial: Trial) -> tuple[object, ...]:
    """What trials have in common that are clocked side by side: the question, whatever the settings."""
    return trial.experiment.name, trial.case, repr(trial.parameters)
