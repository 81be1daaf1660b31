"""The timing run: what a simulated second costs, in fresh processes and randomised interleaved blocks.

Protocol: each trial of a group gets a process of its own, with one thread; it warms up, calibrates how many runs of the scene
make one sample, and then waits, pinned to one core and without a garbage collector. Block by block, in a new random order each
time, every process takes one sample. A trial of several workers is that many such processes, each pinned to a core of its own
while there are enough: in its block all take the same number of steps, let go at once. What is clocked, and what is not, stands
in `harness.bench`.
"""

import contextlib
import gc
import os
import random
import resource
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Barrier
from pathlib import Path

import numpy as np

from harness import discover
from harness.bench import Bench, calibrate
from harness.case import Unit
from harness.interrupt import stop_if_asked
from harness.record import Sample, Timing
from harness.study import Trial
from harness.trajectory import Floats
from harness.worker import confine, context

__all__ = ["Clocked", "Team", "clock_group", "joined", "summarise"]

_NOISY = 0.1
"""Half width of the interval, or spread of the canary, relative to its middle, from which a timing counts as unstable."""


def _canary() -> float:
    """Seconds for a fixed kernel that depends on nothing under test."""
    a = np.full((96, 96), 1.0 / 96.0)
    start = time.perf_counter()
    for _ in range(40):
        a = a @ a
    return time.perf_counter() - start


@dataclass(frozen=True, slots=True)
class Place:
    """Where a child stands: its core, whether it is its trial's first, and the gate where workers wait for each other."""

    core: int | None
    first: bool = True
    gate: Barrier | None = None


def _child(pipe: Connection, trial: Trial, place: Place, log: Path) -> None:
    """Send the steps of a sample once, then a sample for each block and number of steps that come down the pipe.

    An exception is sent as text.
    """
    confine(trial.experiment.memory, log)
    try:
        bench = Bench(discover.case(trial.case), discover.adapter(trial.engine), trial)
        steps = calibrate(bench, trial.experiment.sample_seconds)
        if place.core is not None:
            os.sched_setaffinity(0, {place.core})
        pipe.send(steps)
        gc.disable()
        while (order := pipe.recv()) is not None:
            block, steps = order
            if not bench.steady:
                bench.start()
            # Of workers only the first tries the machine, while the others wait: together they would try each other.
            canary = _canary() if place.first else 0.0
            if place.gate is not None:
                place.gate.wait(trial.experiment.deadline)
            switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
            cpu, wall = bench.clock(steps)
            switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw - switches
            pipe.send(
                Sample(
                    process=0, block=block, steps=steps, units=bench.units, cpu=cpu, wall=wall, canary=canary, switches=switches
                )
            )
        bench.stop()
    except Exception as error:
        if place.gate is not None:
            place.gate.abort()
        pipe.send(f"{type(error).__name__}: {error}")


@dataclass(slots=True)
class Clocked:
    """The parent's end of one child that gives samples when it is asked."""

    process: BaseProcess
    pipe: Connection
    trouble: str = ""

    def ask(self, block: int, steps: int) -> None:
        """Ask for a sample of so many steps; that a child has died while it waited is for `answer` to say."""
        with contextlib.suppress(BrokenPipeError, ConnectionError):
            self.pipe.send((block, steps))

    def answer(self, seconds: float) -> object:
        """The next message, or None with `trouble` set after death, an exception or the deadline."""
        try:
            if not self.pipe.poll(seconds):
                self.trouble = f"no answer within {seconds:g} s"
                return None
            message = self.pipe.recv()
        except (EOFError, ConnectionError):
            self.process.join(1.0)
            self.trouble = f"process ended with exit code {self.process.exitcode}"
            return None
        if isinstance(message, str):
            self.trouble = message
            return None
        return message

    def stop(self) -> None:
        """End the child, by force after a second."""
        if not self.trouble:
            with contextlib.suppress(BrokenPipeError, ConnectionError):
                self.pipe.send(None)
            self.process.join(1.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self.pipe.close()


def joined(samples: Sequence[Sample]) -> Sample:
    """The sample of workers that stepped at once: CPU time and units of all, the wall time of the slowest."""
    return replace(
        samples[0],
        units=sum(s.units for s in samples),
        cpu=sum(s.cpu for s in samples),
        wall=max(s.wall for s in samples),
        canary=max(s.canary for s in samples),
        switches=sum(s.switches for s in samples),
    )


@dataclass(slots=True)
class Team:
    """The children of one trial, one a worker, that give a sample together.

    Terms:
        gate: where they wait for each other; kept for as long as they live. steps: of each in a sample; those of the first, so
        that all have the same to do.
    """

    trial: Trial
    children: Sequence[Clocked]
    gate: Barrier | None = None
    steps: int = 0

    @property
    def trouble(self) -> str:
        """Of all children, each once."""
        return "; ".join(dict.fromkeys(child.trouble for child in self.children if child.trouble))

    def calibrated(self, seconds: float) -> None:
        """Wait until every child is ready."""
        answers = [child.answer(seconds) for child in self.children]
        self.steps = answers[0] if isinstance(answers[0], int) else 0

    def sample(self, block: int, seconds: float) -> Sample | None:
        """What all did in this block, or None with `trouble` set."""
        for child in self.children:
            child.ask(block, self.steps)
        answers = [child.answer(seconds) for child in self.children]
        samples = [answer for answer in answers if isinstance(answer, Sample)]
        return joined(samples) if len(samples) == len(answers) else None

    def stop(self) -> None:
        """End all children."""
        for child in self.children:
            child.stop()


def _interval(values: Floats) -> tuple[float, float]:
    """95 % bootstrap interval of the median."""
    from scipy.stats import bootstrap

    if len(values) > 1 and np.ptp(values) > 0:
        found = bootstrap((values,), np.median, method="percentile", n_resamples=2000, rng=0).confidence_interval
        return float(found.low), float(found.high)
    return float(values.min()), float(values.max())


def summarise(trial: Trial, samples: Sequence[Sample], note: str = "", unit: Unit = "step") -> Timing:
    """Median and 95 % bootstrap interval of CPU seconds per unit of work.

    Per simulated second too, wherever the work is that of stepping and nothing stood beside it.
    """
    if not samples:
        return Timing(trial=trial.trial, note=note or "no sample was taken")
    cpu = np.array([s.cpu / (s.steps * s.units) for s in samples])
    wall = np.array([s.wall / (s.steps * s.units) for s in samples])
    canary = np.array([s.canary for s in samples])
    middle, (low, high) = float(np.median(cpu)), _interval(cpu)
    wide = (high - low) / 2 > _NOISY * middle
    noisy = float(np.percentile(canary, 75) - np.percentile(canary, 25)) > _NOISY * float(np.median(canary))
    timing = Timing(
        trial=trial.trial,
        unit=unit,
        cpu_per_unit=middle,
        cpu_per_unit_low=low,
        cpu_per_unit_high=high,
        unstable_timing=bool(wide or noisy or len(samples) < 3),
        note=note,
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


def _cores() -> list[int | None]:
    """The cores to pin children to, one after the other; the last first, since systems load the first ones."""
    if not hasattr(os, "sched_getaffinity"):
        return [None]
    return [*sorted(os.sched_getaffinity(0), reverse=True)]


def _start(trial: Trial, folder: Path) -> Team:
    forkserver, cores = context(), _cores()
    gate = forkserver.Barrier(trial.workers) if trial.workers > 1 else None
    log = folder / f".timing-{trial.trial}.log"
    children = []
    for worker in range(trial.workers):
        ours, theirs = forkserver.Pipe()
        place = Place(cores[worker % len(cores)], worker == 0, gate)
        process = forkserver.Process(target=_child, args=(theirs, trial, place, log), daemon=True)
        process.start()
        theirs.close()
        children.append(Clocked(process, ours))
    return Team(trial, children, gate)


def clock_group(trials: Sequence[Trial], folder: Path, shuffle: random.Random) -> Iterator[Timing]:
    """Time the trials of one group, interleaved; one `Timing` each, also for those that gave trouble."""
    experiment = trials[0].experiment
    samples: dict[str, list[Sample]] = {trial.trial: [] for trial in trials}
    notes: dict[str, str] = {}
    for number in range(experiment.processes):
        teams = [_start(trial, folder) for trial in trials if not notes.get(trial.trial)]
        try:
            for team in teams:
                team.calibrated(experiment.deadline)
            for block in range(experiment.samples):
                stop_if_asked()
                ready = [team for team in teams if not team.trouble]
                for team in shuffle.sample(ready, len(ready)):
                    sample = team.sample(block, experiment.deadline)
                    if sample is not None:
                        samples[team.trial.trial].append(replace(sample, process=number))
            for team in teams:
                if team.trouble:
                    notes[team.trial.trial] = team.trouble
        finally:
            for team in teams:
                team.stop()
                (folder / f".timing-{team.trial.trial}.log").unlink(missing_ok=True)
    for trial in trials:
        unit = discover.case(trial.case).unit(trial.parameters, trial.clocks)
        yield summarise(trial, samples[trial.trial], notes.get(trial.trial, ""), unit)
