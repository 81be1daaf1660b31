"""The timing run: what a simulated second costs, in fresh processes and randomised interleaved blocks.

Protocol: each trial of a group gets a process of its own, with one thread; it warms up, calibrates how many runs of the scene
make one sample, and then waits, pinned to one core and without a garbage collector. Block by block, in a new random order each
time, every process takes one sample. What is clocked, and what is not, stands in `harness.bench`.
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

__all__ = ["Clocked", "clock_group", "summarise"]

_NOISY = 0.1
"""Half width of the interval, or spread of the canary, relative to its middle, from which a timing counts as unstable."""


def _canary() -> float:
    """CPU seconds for a fixed kernel that depends on nothing under test."""
    a = np.full((96, 96), 1.0 / 96.0)
    start = time.process_time()
    for _ in range(40):
        a = a @ a
    return time.process_time() - start


def _child(pipe: Connection, trial: Trial, core: int | None, log: Path) -> None:
    """Send the steps of a sample once, then a sample for each block that comes down the pipe; an exception is sent as text."""
    confine(trial.experiment.memory, log)
    try:
        bench = Bench(discover.case(trial.case), discover.adapter(trial.engine), trial)
        steps = calibrate(bench, trial.experiment.sample_seconds)
        if core is not None:
            os.sched_setaffinity(0, {core})
        pipe.send(steps)
        gc.disable()
        while (block := pipe.recv()) is not None:
            if not bench.steady:
                bench.stop()
            canary = _canary()
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
        pipe.send(f"{type(error).__name__}: {error}")


@dataclass(slots=True)
class Clocked:
    """The parent's end of one child that gives samples when it is asked."""

    trial: Trial
    process: BaseProcess
    pipe: Connection
    trouble: str = ""

    def sample(self, block: int, seconds: float) -> object:
        """The message that answers a block's number, or None as `answer`; a child that died while it waited is trouble too."""
        with contextlib.suppress(BrokenPipeError, ConnectionError):
            self.pipe.send(block)
        return self.answer(seconds)

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


def _interval(values: Floats) -> tuple[float, float]:
    """95 % bootstrap interval of the median."""
    from scipy.stats import bootstrap

    if len(values) > 1 and np.ptp(values) > 0:
        found = bootstrap((values,), np.median, method="percentile", n_resamples=2000, rng=0).confidence_interval
        return float(found.low), float(found.high)
    return float(values.min()), float(values.max())


def summarise(trial: Trial, samples: Sequence[Sample], note: str = "", unit: Unit = "step") -> Timing:
    """Median and 95 % bootstrap interval of CPU seconds per unit of work, per simulated second too where that is a step."""
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
    if unit == "ray":
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


def _start(trial: Trial, folder: Path, core: int | None) -> Clocked:
    forkserver = context()
    ours, theirs = forkserver.Pipe()
    log = folder / f".timing-{trial.trial}.log"
    process = forkserver.Process(target=_child, args=(theirs, trial, core, log), daemon=True)
    process.start()
    theirs.close()
    return Clocked(trial, process, ours)


def clock_group(trials: Sequence[Trial], folder: Path, shuffle: random.Random) -> Iterator[Timing]:
    """Time the trials of one group, interleaved; one `Timing` each, also for those that gave trouble."""
    experiment = trials[0].experiment
    core = max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None
    samples: dict[str, list[Sample]] = {trial.trial: [] for trial in trials}
    notes: dict[str, str] = {}
    for number in range(experiment.processes):
        children = [_start(trial, folder, core) for trial in trials if not notes.get(trial.trial)]
        try:
            for child in children:
                child.answer(experiment.deadline)
            for block in range(experiment.samples):
                stop_if_asked()
                ready = [child for child in children if not child.trouble]
                for child in shuffle.sample(ready, len(ready)):
                    message = child.sample(block, experiment.deadline)
                    if isinstance(message, Sample):
                        samples[child.trial.trial].append(replace(message, process=number))
            for child in children:
                if child.trouble:
                    notes[child.trial.trial] = child.trouble
        finally:
            for child in children:
                child.stop()
                (folder / f".timing-{child.trial.trial}.log").unlink(missing_ok=True)
    for trial in trials:
        unit = discover.case(trial.case).unit(trial.parameters)
        yield summarise(trial, samples[trial.trial], notes.get(trial.trial, ""), unit)
