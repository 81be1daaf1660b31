"""The timing run: what a simulated second costs, in fresh processes and randomised interleaved blocks.

Protocol: each trial of a group gets a process of its own, with one thread; it warms up, calibrates how many runs of the scene
make one sample, and then waits, pinned to one core and without a garbage collector. Block by block, in a new random order each
time, every process takes one sample. Building, resetting and reading are outside the clock; inside it is one call of `step`.
"""

import contextlib
import gc
import math
import os
import random
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

import numpy as np

from harness import discover
from harness.adapter import Simulation
from harness.record import Sample, Timing
from harness.study import Trial
from harness.worker import confine, context

__all__ = ["Clocked", "clock_group", "clock_steps", "summarise"]

_LONGEST = 10.0
"""A single run of a scene is cut off after this many times the sample's length."""
_NOISY = 0.1
"""Half width of the interval, or spread of the canary, relative to its middle, from which a timing counts as unstable."""


def _canary() -> float:
    """Seconds for a fixed kernel that depends on nothing under test."""
    a = np.full((96, 96), 1.0 / 96.0)
    start = time.perf_counter()
    for _ in range(40):
        a = a @ a
    return time.perf_counter() - start


@dataclass(slots=True)
class _Plan:
    """How one sample is made: `runs` runs of `steps` steps each."""

    runs: int
    steps: int


def clock_steps(simulation: Simulation, steps: int) -> tuple[float, float]:
    """CPU and wall seconds of one call of `step`."""
    wall, cpu = time.perf_counter(), time.process_time()
    simulation.step(steps)
    return time.process_time() - cpu, time.perf_counter() - wall


def _child(pipe: Connection, trial: Trial, core: int | None, log: Path) -> None:
    """Answer 'plan' once, then a sample for each block number that comes down the pipe; any exception is sent back as text."""
    confine(trial.experiment.memory, log)
    try:
        case, adapter = discover.case(trial.case), discover.adapter(trial.engine)
        scene = case.scene(**trial.parameters)
        whole = max(1, round(case.duration / trial.settings.dt))
        plan = _calibrate(lambda: adapter.build(scene, trial.settings), whole, trial.experiment.sample_seconds)
        if core is not None:
            os.sched_setaffinity(0, {core})
        pipe.send(plan)
        gc.disable()
        while (block := pipe.recv()) is not None:
            canary, cpu, wall = _canary(), 0.0, 0.0
            switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
            for _ in range(plan.runs):
                simulation = adapter.build(scene, trial.settings)
                one_cpu, one_wall = clock_steps(simulation, plan.steps)
                simulation.close()
                cpu, wall = cpu + one_cpu, wall + one_wall
            switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw - switches
            pipe.send((block, plan.runs * plan.steps, cpu, wall, canary, switches))
    except Exception as error:
        pipe.send(f"{type(error).__name__}: {error}")


def _calibrate(build: Callable[[], Simulation], whole: int, seconds: float) -> _Plan:
    """Warm up and find the plan whose sample lasts `seconds`, cutting a run that would last much longer."""
    simulation = build()
    simulation.step(1)
    done, spent = 1, 0.0
    while done < whole and spent < _LONGEST * seconds:
        count = min(max(1, whole // 20), whole - done)
        spent += clock_steps(simulation, count)[1]
        done += count
    simulation.close()
    if done < whole:
        return _Plan(1, done)
    return _Plan(max(1, math.ceil(seconds / max(spent, 1e-7))) if whole > 1 else 1, whole)


@dataclass(slots=True)
class Clocked:
    """The parent's end of one child that gives samples when it is asked."""

    trial: Trial
    process: BaseProcess
    pipe: Connection
    plan: _Plan | None = None
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


def summarise(trial: Trial, samples: Sequence[Sample], note: str = "") -> Timing:
    """Median and 95 % bootstrap interval of CPU seconds per simulated second; the verdict on its stability."""
    if not samples:
        return Timing(trial=trial.trial, note=note or "no sample was taken")
    from scipy.stats import bootstrap

    dt = trial.settings.dt
    cpu = np.array([s.cpu / (s.steps * dt) for s in samples])
    wall = np.array([s.wall / (s.steps * dt) for s in samples])
    canary = np.array([s.canary for s in samples])
    middle = float(np.median(cpu))
    if len(cpu) > 1 and np.ptp(cpu) > 0:
        interval = bootstrap((cpu,), np.median, method="percentile", n_resamples=2000, rng=0).confidence_interval
        low, high = float(interval.low), float(interval.high)
    else:
        low, high = float(cpu.min()), float(cpu.max())
    wide = (high - low) / 2 > _NOISY * middle
    noisy = float(np.percentile(canary, 75) - np.percentile(canary, 25)) > _NOISY * float(np.median(canary))
    return Timing(
        trial=trial.trial,
        cpu_per_sim_s=middle,
        cpu_low=low,
        cpu_high=high,
        wall_per_sim_s=float(np.median(wall)),
        realtime_factor=float(1.0 / np.median(wall)),
        unstable_timing=bool(wide or noisy or len(samples) < 3),
        note=note,
        samples=tuple(samples),
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
                plan = child.answer(experiment.deadline)
                child.plan = plan if isinstance(plan, _Plan) else None
            for block in range(experiment.samples):
                ready = [child for child in children if not child.trouble]
                for child in shuffle.sample(ready, len(ready)):
                    message = child.sample(block, experiment.deadline)
                    if isinstance(message, tuple):
                        _, steps, cpu, wall, canary, switches = message
                        samples[child.trial.trial].append(
                            Sample(
                                process=number, block=block, steps=steps, cpu=cpu, wall=wall, canary=canary, switches=switches
                            )
                        )
            for child in children:
                if child.trouble:
                    notes[child.trial.trial] = child.trouble
        finally:
            for child in children:
                child.stop()
                (folder / f".timing-{child.trial.trial}.log").unlink(missing_ok=True)
    for trial in trials:
        yield summarise(trial, samples[trial.trial], notes.get(trial.trial, ""))
