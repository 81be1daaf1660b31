"""The timing run: what a simulated second costs, in fresh processes and randomised interleaved blocks.

Protocol: each engine of a sitting gets a process, with one thread, that serves all of its trials; it warms up, calibrates for
each how many whole runs of the scene make one sample, and then waits, pinned to one core and without a garbage collector. The
questions of the sitting follow each other in random order. Block by block, in a new random order each time, every trial of a
question takes one sample; then all begins anew in fresh processes, off another fork server and so laid out otherwise in memory,
and later: the samples of a trial are spread over the sitting, so that they feel how the machine's speed drifts. A trial whose
runs are long takes three samples, or one where there is no time for more, spread over the processes; one that does not fit its
deadline is not clocked. A trial of several workers has that many processes for itself, each pinned to a core of its own while
there are enough: in its block all take the same number of steps, let go at once. What is clocked, and what is not, stands in
`harness.trial.bench`; the processes in `harness.run.timed_processes`.
"""

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np

from plumbline.harness.case import Case, Unit
from plumbline.harness.case.undropped import called
from plumbline.harness.run.interrupt import stop_if_asked
from plumbline.harness.run.timed_processes import Team, ready_teams
from plumbline.harness.statistics.bootstrap import interval_of_median, with_drift
from plumbline.harness.store.record import Record, Sample, Timing
from plumbline.harness.study import plugins
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


_NOISY = 0.1
"""Half width of the interval, or spread of the canary, relative to its middle, from which a timing counts as unstable."""
DRIFT = 0.016
"""How far a machine's speed strays from one minute to another, root mean square and relative.

Measured on a busy one over 80 minutes, as medians of three samples in a minute, of three kernels: .016 (products of matrices),
.013 (MuJoCo's steps of three boxes), .017 (Python). Of two minutes the intervals of .03 to .05 do not overlap without it,
below .01 with it.
"""


def summarise(trial: Trial, samples: Sequence[Sample], note: str = "", unit: Unit = "step") -> Timing:
    """Median and 95 % bootstrap interval of CPU seconds per unit of work, of what repeats in other processes would show.

    Per simulated second too, wherever the work is that of stepping and nothing stood beside it.
    """
    if not samples:
        return Timing(trial=trial.trial, clocked="not clocked", note=note or "no sample was taken")
    cpu = np.array([s.cpu / (s.steps * s.units) for s in samples])
    wall = np.array([s.wall / (s.steps * s.units) for s in samples])
    canary = np.array([s.canary for s in samples])
    middle = float(np.median(cpu))
    low, high = with_drift(middle, interval_of_median(cpu, [s.process for s in samples]), DRIFT)
    wide = (high - low) / 2 > _NOISY * middle
    noisy = float(np.percentile(canary, 75) - np.percentile(canary, 25)) > _NOISY * float(np.median(canary))
    shares = [s.emulated for s in samples if s.emulated is not None]
    timing = Timing(
        trial=trial.trial,
        unit=unit,
        cpu_per_unit=middle,
        cpu_per_unit_low=low,
        cpu_per_unit_high=high,
        unstable_timing=bool(wide or noisy or len(samples) < 3),
        note=note,
        clocked="whole runs" if samples[0].run else "calls",
        emulated=float(np.median(shares)) if shares else None,
        samples=tuple(samples),
    )
    if unit not in ("step", "world-step") or trial.workers > 1:
        return timing
    dt = trial.settings.dt
    return replace(
        timing,
        cpu_per_sim_s=middle / dt,
        cpu_low=low / dt,
        cpu_high=high / dt,
        wall_per_sim_s=float(np.median(wall)) / dt,
        realtime_factor=dt / float(np.median(wall)),
    )


def clock_group(
    trials: Sequence[Trial], folder: Path, shuffle: random.Random, say: Callable[[str], None] = lambda _: None
) -> Iterator[Timing]:
    """Time the trials of one sitting; one `Timing` each, also for those that gave trouble.

    Args: trials: of one experiment; those of one question stand one after the other. say: is told what is clocked now.
    """
    experiment = trials[0].experiment
    questions = [tuple(question) for _, question in groupby(trials, key=together)]
    samples: dict[str, list[Sample]] = {trial.trial: [] for trial in trials}
    notes: dict[str, str] = {}
    most = dict.fromkeys(samples, experiment.processes * experiment.samples)
    for number in range(experiment.processes):
        teams: dict[str, Team] = {}
        try:
            due = [trial for trial in trials if trial.trial not in notes and len(samples[trial.trial]) < most[trial.trial]]
            teams = ready_teams(due, folder, number)
            for name, team in teams.items():
                if number == 0 and team.sampling is not None and team.sampling.most is not None:
                    most[name] = min(most[name], team.sampling.most)
            processes = experiment.processes - number
            here = {name: -(-(most[name] - len(samples[name])) // processes) for name in teams}  # rounded up
            for question in shuffle.sample(questions, len(questions)):
                say(f"{called(question[0].case)}, processes {number + 1} of {experiment.processes}")
                for block in range(experiment.samples):
                    stop_if_asked()
                    asked = sorted(trial.trial for trial in question if block < here.get(trial.trial, 0))
                    for name in shuffle.sample(asked, len(asked)):
                        sample = _sample(teams, name, block, folder, number)
                        if sample is not None:
                            samples[name].append(replace(sample, process=number))
        finally:
            for name, team in teams.items():
                notes |= {name: team.trouble} if team.trouble else {}
                team.stop()
            for trial in trials:
                (folder / f".timing-{trial.trial}.log").unlink(missing_ok=True)
    for trial in trials:
        unit = plugins.case(trial.case).unit(trial.parameters, trial.clocks)
        yield summarise(trial, samples[trial.trial], notes.get(trial.trial, ""), unit)


def _sample(teams: dict[str, Team], name: str, block: int, folder: Path, server: int) -> Sample | None:
    """A sample of one team, of a new one where its processes died of another trial; None where it is in trouble."""
    sample = None
    while sample is None and not teams[name].trouble:
        if teams[name].lost:
            lost = [team for team in teams.values() if team.lost]
            teams |= ready_teams([team.trial for team in lost], folder, server, apart=True)
            for team in lost:
                team.stop()
        if not teams[name].trouble:
            sample = teams[name].sample(block, teams[name].trial.experiment.deadline)
    return sample
