"""Accuracy runs in processes of their own: a crash, a hang or a leak costs one trial and is a record."""

import signal
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import MappingProxyType

from plumbline.harness.case.alteration import ALONE
from plumbline.harness.intake.bounded import named_signal
from plumbline.harness.intake.deadline import Deadline
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.run.child import answers, confine, end_started, roughly_clocked
from plumbline.harness.run.fork_servers import Origin, end_servers, loaded, start
from plumbline.harness.run.interrupt import MemoryWatch, kills_for_memory, naming, stop_if_asked
from plumbline.harness.run.message import BrokenMessage, Inbox, Worker, read_record, send
from plumbline.harness.store.record import Record, StoredNotice
from plumbline.harness.study import plugins
from plumbline.harness.study.environments import elsewhere
from plumbline.harness.study.library_variants import obstacle
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome, unjudged

_TAIL = 4000
_KEPT = 2**20
"""Bytes of a log that stay on disk."""
_LISTENS = 1.0
"""Seconds between looks at whether the run is to stop."""
_QUIET = ("passed", "failed", "unsupported")


def _tail(log: Path) -> str:
    if not log.is_file():
        return ""
    with log.open("rb") as stream:
        stream.seek(max(0, log.stat().st_size - _TAIL))
        return readable(stream.read().decode("utf-8", errors="replace").strip())


def _trim(log: Path, record: Record) -> None:
    """Drop the log of a trial that ended well, and all but the end of one that was flooded."""
    if not log.is_file():
        return
    size = log.stat().st_size
    if size == 0 or record.status in _QUIET:
        log.unlink()
    elif size > _KEPT:
        with log.open("rb") as stream:
            stream.seek(size - _KEPT)
            end = stream.read()
        log.write_bytes(end)


def _expired(trial: Trial, code: int | None, log: Path, kills: int) -> Record:
    """Terms: kills: of the system for want of memory, while the trial ran."""
    detail = _tail(log)
    if code == -signal.SIGKILL and kills:
        return outcome(trial, "oom", f"killed by the system, which killed {kills} times for want of memory meanwhile", detail)
    if code is not None and code < 0:
        return outcome(trial, "crashed", f"killed by {named_signal(-code)}", detail)
    return outcome(trial, "crashed", f"process ended with exit code {code} and no result", detail)


@dataclass(slots=True)
class _Child(Worker):
    """A process at work on a trial.

    Terms:
        inbox: its record comes here, the last word counts. deadline: of what it does now, loading its
        engine or answering. kills: of the system for want of memory, before it began. begun: when it was started, on the
        monotonic clock [s]. said: what has come so far. broken: what it said that no child may say; it is heard no more.
        answered: what is known of an answer that is being judged, when memory and time are those of metrics and truths.
        earlier: the trial whose answer it may judge in place of simulating, '' for none.
        ended: has it said its last word, or died? late: why it is; nothing where it is not. ready: has it loaded its engine?
    """

    trial: Trial
    log: Path
    deadline: Deadline
    kills: int
    begun: float
    earlier: str = ""
    said: Record | None = None
    answered: Record | None = None
    broken: str = ""
    ended: bool = False
    late: str = ""
    ready: bool = False

    def listen(self) -> bool:
        """Take what has come: has it said its last word or died, or is it late?"""
        try:
            for kind, value in self.inbox.lines():
                if kind == "ready" and not self.ready:
                    self.ready, self.deadline = True, Deadline(self.process.pid, self.trial.deadline)
                elif kind == "answered":
                    if self.answered is None:
                        self.deadline = Deadline(self.process.pid, self.trial.deadline)
                    self.answered = read_record(self.trial, value)
                elif kind == "record":
                    self.said = read_record(self.trial, value, self.earlier)
                else:
                    raise BrokenMessage(f"a '{readable(kind, 80)}', expected a record")
            self.ended = self.inbox.ended
        except BrokenMessage as error:
            self.broken = f"broken contract: {error}"
        self.late = self.deadline.passed()
        return self.ended or bool(self.broken) or bool(self.late)

    def record(self) -> Record | None:
        """Its record, or its outcome; None if the fork server that it may have shared with others died.

        The process has ended then.
        """
        try:
            code = self.process.exit_code() if self.ended else None
            if self.said is not None and (self.said.rough_cost or not roughly_clocked(self.trial, self.said)):
                return self.said
            if self.process.lost:
                alone = bool(self.process.origin.only)
                return outcome(self.trial, "crashed", "its fork server died with it, alone too") if alone else None
            end = self._end(code)
            if self.said is None and self.answered is not None and end.status in ("oom", "timeout"):
                return self._unjudged(self.answered, end)
            if self.said is None or code == 0:
                return self.said or end
            return replace(
                self.said, warnings=(*self.said.warnings, StoredNotice(f"rough cost: none: {end.reason}", by="rough clock"))
            )
        finally:
            self.stop()

    def _unjudged(self, answered: Record, end: Record) -> Record:
        """What an engine answered, where judging it took more than the trial may."""
        if answered.status == "diverged":
            return answered
        return unjudged(answered, plugins.case(self.trial.case), f"judging the answer took too much: {end.reason}")

    def _end(self, code: int | None) -> Record:
        if self.broken:
            return outcome(self.trial, "crashed", self.broken, _tail(self.log))
        if self.watch is not None and self.watch.taken:
            most = self.trial.experiment.memory
            return outcome(self.trial, "oom", f"more than {most:g} MB: it took {self.watch.taken:.0f} MB", _tail(self.log))
        if self.ended:
            return _expired(self.trial, code, self.log, kills_for_memory() - self.kills)
        reason = f"deadline of {self.trial.deadline:g} s passed, {self.late}"
        return outcome(self.trial, "timeout", reason, _tail(self.log))


def _answer(pipe: Connection, trial: Trial, folder: Path, log: Path, earlier: Record | None) -> None:
    confine(log)
    tell(pipe, trial, folder, earlier)
    end_started()
    pipe.close()


def tell(pipe: Connection, trial: Trial, folder: Path, earlier: Record | None = None) -> None:
    """Run a trial in this process, and say when its engine is ready, and what came of it."""

    def answered(record: Record) -> None:
        with suppress(TypeError, ValueError):  # what cannot be sent is refused with the whole record
            send(pipe, "answered", record)

    for record in answers(trial, folder, answered, earlier):
        try:
            send(pipe, "ready" if record is None else "record", record)
        except (TypeError, ValueError) as error:
            send(pipe, "record", outcome(trial, "crashed", f"broken contract: {error}"))


def _origin(trial: Trial, foreseen: int) -> Origin:
    """The fork server that suits a trial."""
    environment = elsewhere(trial.engine)
    if trial.alteration.variables:
        return Origin(environment=environment, variables=trial.alteration.variables)
    if trial.experiment.determinism:
        # Whether another process answers the same is asked of one that does not even have things at the same place in memory.
        return Origin(environment=environment, number=1 if trial.alteration.name in ("again", ALONE) else 0)
    return loaded(plugins.adapter(trial.engine).loads, foreseen, environment)


def _start(trial: Trial, origin: Origin, folder: Path, logs: Path, earlier: Record | None) -> _Child | Record:
    """A process at work on the trial; a record if no server can be born with the trial's variables."""
    kills, log = kills_for_memory(), logs / f"{trial.trial}.log"
    log.unlink(missing_ok=True)
    try:
        process = start(origin, _answer, trial, folder, log, earlier)
    except ConnectionError as error:
        if not trial.alteration.variables:
            raise
        return outcome(trial, "crashed", f"with {', '.join('='.join(each) for each in trial.alteration.variables)}: {error}")
    loading = Deadline(process.pid, trial.experiment.deadline + plugins.adapter(trial.engine).compile_allowance)
    watch = MemoryWatch(process.pid, trial.experiment.memory)
    simulated_as = "" if earlier is None else earlier.simulated_as or earlier.trial
    return _Child(process, watch, Inbox(process.pipe), trial, log, loading, kills, time.monotonic(), simulated_as)


def run_isolated(
    trials: Sequence[Trial], folder: Path, workers: int, foreseen: int = 0, earlier: Mapping[str, Record] = MappingProxyType({})
) -> Iterator[Record]:
    """Records as they come in, one for each trial; leaving the iterator early stops all children.

    Args: foreseen: trials that an engine will have in all, where there are more to come than these. earlier: by trial, the
    record of one of the same motion whose answer is judged anew, and simulated where its file is not as it was written.
    A trial whose fork server died under it runs again, off a server of its own. Several threads may run this, each in a folder
    of its own.
    """
    obstacles = {trial.trial: reason for trial in trials if (reason := obstacle(trial.alteration.variables))}
    yield from (outcome(trial, "unavailable", obstacles[trial.trial]) for trial in trials if trial.trial in obstacles)
    logs = folder / "logs"
    logs.mkdir(exist_ok=True)
    waiting = [trial for trial in reversed(trials) if trial.trial not in obstacles]
    engines = Counter(trial.engine for trial in trials)
    running, forsaken, varied = list[_Child](), set[str](), set[Origin]()
    try:
        while waiting or running:
            if waiting and len(running) < workers:
                trial = waiting.pop()
                origin = _origin(trial, max(foreseen, engines[trial.engine]))
                varied |= {origin} if origin.variables else set()
                origin = replace(origin, only=trial.trial if trial.trial in forsaken else "")
                started = _start(trial, origin, folder, logs, earlier.get(trial.trial))
                if isinstance(started, Record):
                    yield started
                else:
                    running.append(started)
                continue
            soonest = min(child.deadline.until for child in running) - time.monotonic()
            wait([child.inbox.pipe for child in running], timeout=min(_LISTENS, max(0.0, soonest)))
            with naming((child.trial, child.begun) for child in running):
                stop_if_asked()
            for child in [child for child in running if child.listen()]:
                running.remove(child)
                record = child.record()
                if record is None:
                    forsaken.add(child.trial.trial)
                    waiting.append(child.trial)
                    continue
                _trim(child.log, record)
                yield record
    finally:
        for child in running:
            child.stop()
        end_servers(varied)  # few processes want them
        if not any(logs.iterdir()):
            logs.rmdir()
