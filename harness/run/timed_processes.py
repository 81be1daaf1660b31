"""The processes under the clock: what they do, how they are started, and the parent's end of them.

A process serves the trials of one engine in turn, so that an engine is loaded once and not once a trial; where it dies, the
trial that it died of is told, and the others get a new one. A trial of several workers has that many processes for itself.
"""

import gc
import os
import resource
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from plumbline.harness.intake.deadline import Deadline
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.run.child import confine, end_started
from plumbline.harness.run.fork_servers import Origin, start
from plumbline.harness.run.interrupt import MemoryWatch, hour, naming, stop_if_asked
from plumbline.harness.run.message import BrokenMessage, Inbox, Worker, read_sampling, read_value, send
from plumbline.harness.store.record import Sample
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import elsewhere
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import LONG, Bench, NotClocked, Sampling, calibrate
from plumbline.harness.trial.emulated_share import emulated_share

_LOOKS = 0.5
"""Seconds between looks at the memory of a process under the clock; each takes an eighth of a millisecond of another core."""


def _canary() -> float:
    """CPU seconds of a fixed kernel that depends on nothing under test: the middle of three, as the first finds cold caches."""
    a = np.full((96, 96), 1.0 / 96.0)
    taken = []
    for _ in range(3):
        start = time.process_time()
        for _ in range(40):
            a = a @ a
        taken.append(time.process_time() - start)
    return sorted(taken)[1]


@dataclass(frozen=True, slots=True)
class ProcessPlace:
    """Where a child stands: its core, whether it is its trial's first, and whether workers start together."""

    core: int | None
    first: bool = True
    together: bool = False


def _child(pipe: Connection, trials: Sequence[Trial], place: ProcessPlace, log: Path) -> None:
    """Send how each trial is sampled, then a sample for each order (trial's number, block, sampling) that comes.

    An exception is sent as text in place of either; a trial that raised one is not asked again.
    """
    confine(log)
    benches: dict[int, Bench] = {}
    for number, trial in enumerate(trials):
        try:
            adapter = plugins.adapter(trial.engine)
            bench = Bench(plugins.case(trial.case), adapter, trial)
            try:
                sampling = calibrate(bench, trial.experiment.sample_seconds, trial.experiment.deadline)
            finally:
                if not bench.endless:
                    bench.stop()
            own = emulated_share(bench, adapter.laws, LONG * trial.experiment.sample_seconds)
            benches[number] = bench
            send(pipe, "sampling", replace(sampling, emulated=own))
        except NotClocked as error:
            send(pipe, "trouble", str(error))
        except Exception as error:
            send(pipe, "trouble", f"{type(error).__name__}: {error}")
    if place.core is not None:
        os.sched_setaffinity(0, {place.core})
    gc.disable()
    while (order := pipe.recv()) is not None:
        try:
            number, block, sampling = order
            if (sample := _sample(pipe, benches[number], block, sampling, place)) is not None:
                send(pipe, "sample", sample)
        except Exception as error:
            send(pipe, "trouble", f"{type(error).__name__}: {error}")
    for bench in benches.values():
        bench.stop()
    end_started()


def _sample(pipe: Connection, bench: Bench, block: int, sampling: Sampling, place: ProcessPlace) -> Sample | None:
    """What was clocked; None where the workers were not let go, as one of them is in trouble."""
    if not bench.endless:
        bench.start()
    # Of workers only the first tries the machine, while the others wait: together they would try each other.
    canary = _canary() if place.first else 0.0
    if place.together:
        send(pipe, "waiting", None)
        if not pipe.recv():
            return None
    switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
    cpu, wall = bench.clock(sampling.steps)
    switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw - switches
    if not bench.endless:
        bench.stop()
    return Sample(
        process=0,
        block=block,
        steps=sampling.steps,
        units=bench.units,
        cpu=cpu,
        wall=wall,
        canary=canary,
        switches=switches,
        run=sampling.run,
        emulated=sampling.emulated,
    )


@dataclass(frozen=True, slots=True)
class Ready:
    """A worker is ready to start as soon as the others are."""


@dataclass(slots=True)
class Clocked(Worker):
    """The parent's end of one child. Terms: trouble: what it died of; it serves nobody then."""

    trouble: str = ""

    def ask(self, number: int, block: int, sampling: Sampling) -> None:
        """Ask for a sample."""
        self.tell((number, block, sampling))

    def answer(self, seconds: float) -> Sampling | Sample | Ready | str | None:
        """The next message, a text where something went wrong, None where nobody knows whose fault it was.

        `trouble` is set after death or the deadline. Raises: TimeIsUp, where that comes first.
        """
        deadline, why = Deadline(self.process.pid, seconds), ""
        try:
            while not why:
                if (message := self.inbox.next(max(0.0, min(deadline.until, hour()) - time.monotonic()))) is not None:
                    return _read(*message)
                stop_if_asked()
                why = deadline.passed()
            self.trouble = f"no answer within {seconds:g} s, {why}"
            self.process.kill()
        except EOFError:
            self.trouble = self._death(self.process.exit_code())
        except BrokenMessage as error:
            self.trouble = f"broken contract: {error}"
            self.process.kill()
        return None if self.trouble and self.process.lost and not self.process.origin.only else self.trouble

    def _death(self, code: int | None) -> str:
        if self.watch is not None and self.watch.taken:
            return f"took {self.watch.taken:.0f} MB of memory, more than its trials may together"
        if self.process.lost:
            return "its fork server died with it"
        return f"process ended with exit code {code}"

    def stop(self) -> None:
        """End the child, by force after a second; may be called twice."""
        if self.inbox.pipe.closed:
            return
        if not self.trouble:
            self.tell(None)
            self.process.join(1.0)
        Worker.stop(self)


def _read(kind: str, value: object) -> Sampling | Sample | Ready | str:
    """What a child told: how it samples, that it waits, a sample, or what went wrong. Raises: BrokenMessage."""
    if kind == "sample":
        return read_value(Sample, value)
    if kind == "sampling":
        return read_sampling(value)
    if kind == "waiting":
        return Ready()
    if kind == "trouble" and isinstance(value, str):
        return readable(value)
    raise BrokenMessage(f"{readable(kind, 80)}: got {readable(repr(value), 80)}, expected 'sampling', a 'sample' or 'trouble'")


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
        number: of the trial among those that its children serve. sampling: that of the first, so that all have the same to do;
        None in trouble. trouble: of this trial.
    """

    trial: Trial
    children: Sequence[Clocked]
    number: int = 0
    sampling: Sampling | None = None
    trouble: str = ""

    @property
    def lost(self) -> bool:
        """Did a child die of another trial, or with its server?"""
        return not self.trouble and any(child.trouble for child in self.children)

    def calibrated(self, seconds: float) -> None:
        """Wait until every child is ready for this trial. Raises: TimeIsUp."""
        with naming([(self.trial, time.monotonic())]):
            answers = [child.answer(seconds) for child in self.children]
        self._note(answers)
        self.sampling = answers[0] if isinstance(answers[0], Sampling) else None

    def sample(self, block: int, seconds: float) -> Sample | None:
        """What all did in this block, or None, with `trouble` set or lost; only asked of who is ready. Raises: TimeIsUp."""
        assert self.sampling is not None
        for child in self.children:
            child.ask(self.number, block, self.sampling)
        with naming([(self.trial, time.monotonic())]):
            answers = [child.answer(seconds) for child in self.children]
            ready = [isinstance(answer, Ready) for answer in answers]
            for child in (child for child, waits in zip(self.children, ready, strict=True) if waits):
                child.tell(all(ready))
            if all(ready):
                answers = [child.answer(seconds) for child in self.children]
        self._note(answers)
        samples = [answer for answer in answers if isinstance(answer, Sample)]
        return joined(samples) if len(samples) == len(answers) else None

    def _note(self, answers: Iterable[Sampling | Sample | Ready | str | None]) -> None:
        self.trouble = "; ".join(dict.fromkeys(answer for answer in answers if isinstance(answer, str)))

    def stop(self) -> None:
        """End all children, those of its mates with them."""
        for child in self.children:
            child.stop()


def _cores() -> list[int | None]:
    """The cores to pin children to, one after the other; the last first, since systems load the first ones."""
    if not hasattr(os, "sched_getaffinity"):
        return [None]
    return [*sorted(os.sched_getaffinity(0), reverse=True)]


def _start(trials: Sequence[Trial], folder: Path, server: int, apart: bool) -> Iterator[Team]:
    """The teams of these trials: one child for all of an engine's with one worker, own children for each of the others.

    Args: apart: each with a server of its own.
    """
    cores = _cores()
    alone = [[trial] for trial in trials if trial.workers > 1]
    engines = dict.fromkeys(trial.engine for trial in trials if trial.workers == 1)
    together = [[trial for trial in trials if trial.workers == 1 and trial.engine == engine] for engine in engines]
    for served in (*together, *alone):
        workers = served[0].workers
        origin = Origin(number=server, only=served[0].trial if apart else "", environment=elsewhere(served[0].engine))
        log = folder / f".timing-{served[0].trial}.log"
        children = []
        for worker in range(workers):
            place = ProcessPlace(cores[worker % len(cores)], worker == 0, workers > 1)
            process = start(origin, _child, served, place, log)
            watch = MemoryWatch(process.pid, sum(trial.experiment.memory for trial in served), _LOOKS)
            children.append(Clocked(process, watch, Inbox(process.pipe)))
        yield from (Team(trial, children, number) for number, trial in enumerate(served))


def ready_teams(trials: Sequence[Trial], folder: Path, server: int = 0, apart: bool = False) -> dict[str, Team]:
    """A team for each trial, by the trial's name, ready or in trouble; whose process died of another trial got a new one.

    Terms: server: the number of the fork server that all come from; an engine whose process is lost gets a server of its own of
    that number. apart: they have them from the beginning.
    Raises: TimeIsUp; nobody is left behind then.
    """
    ready: dict[str, Team] = {}
    waiting = list(trials)
    while waiting:
        started = list(_start(waiting, folder, server, apart))
        try:
            for team in started:
                if not team.lost:
                    team.calibrated(team.trial.experiment.deadline)
        except BaseException:
            for team in (*started, *ready.values()):
                team.stop()
            raise
        for team in started:
            if team.lost:
                team.stop()
            else:
                ready[team.trial.trial] = team
        waiting = [team.trial for team in started if team.lost]
        apart = True
    return ready
