"""The coordinator's end of a cluster: cells handed out, results stored before they are let go, groups clocked host by host.

A result stays with the cluster until whoever asked for it has written it down, so that one that is lost on the way is made
again. A cell whose worker is lost runs once more elsewhere; one that loses two is given up for now. A timing group runs
on one host, alone, and all groups of a run on hosts of one fingerprint.
"""

import logging
import queue
import re
import time
import uuid
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.run.cluster.cells import KEPT, Answered, OtherPlumbline, answer_cell, clock_together, here
from plumbline.harness.run.interrupt import stop_if_asked
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.record import Record, Timing, from_plain
from plumbline.harness.store.seal import Damaged, require_seal
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome

_CONNECTS = 30.0
"""Seconds that a scheduler may take to answer, and its first worker to come."""
_GONE = 15.0
"""Seconds without the scheduler after which it counts as gone."""
_LISTENS = 0.5
_AHEAD = 4
"""Cells that are handed out for each thread of a worker: one at work, the others on their way."""
_FEWEST = 64
_LOOKS = ("profile", "profile-cycle", "tick", "monitor")
"""What dask's processes do many times a second for its dashboard."""
_LOSSES = 1
"""Workers that may be lost under a cell before it is given up: it runs elsewhere once."""


_PLACE = re.compile(rf"({'|'.join(KEPT)})/[^./\\\0][^/\\\0]*")


class NoScheduler(StoreError):
    """A scheduler that does not answer, or not any more; the message says what is safe and how to go on."""


class NoDask(PlumblineError):
    """dask.distributed is not installed."""


def _lose_once(dask_scheduler: Any) -> None:
    """Runs on the scheduler: cells whose worker is lost may run once more; it does not look at itself either."""
    dask_scheduler.allowed_failures = _LOSSES
    _end_looks(dask_scheduler)


def _unwatched(dask_worker: Any) -> None:
    """Runs on a worker: it no longer looks at itself a hundred times a second, which costs a third of its CPU time."""
    _end_looks(dask_worker)


def _end_looks(server: Any) -> None:
    for name in _LOOKS:
        if name in server.periodic_callbacks:
            server.periodic_callbacks[name].stop()


class Workplace:
    """The workers of a scheduler; use as a context.

    Terms: machine: the fingerprint of the hosts that clock, those of the kind that most of the workers' hosts are of.
    """

    def __init__(self, address: str) -> None:
        """Raises: NoScheduler, NoDask."""
        try:
            from distributed import Client
        except ImportError as error:
            raise NoDask(f"--scheduler: {error}; pip install 'plumbline[dask]'") from None
        self.address, self._modules, self._run = address, tuple[str, ...](), uuid.uuid4().hex
        self._dask_is_quiet()
        try:
            connect: Any = Client
            self._client: Any = connect(address, timeout=_CONNECTS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise NoScheduler(f"{address}: no scheduler answers ({type(error).__name__}: {error})") from None
        try:
            self._client.wait_for_workers(1, timeout=_CONNECTS)
            self._client.run_on_scheduler(_lose_once)
            self._client.run(_unwatched)
            self._kinds: dict[str, Mapping[str, Any]] = self._client.run(here)
        except (OSError, ValueError) as error:
            self.close()
            raise NoScheduler(f"{address}: its workers do not come ({type(error).__name__}: {error})") from None
        by_host = {_host(worker): machine_digest(kind) for worker, kind in self._kinds.items()}
        self._clocks = Counter(by_host.values()).most_common(1)[0][0]
        self.machine = next(kind for kind in self._kinds.values() if machine_digest(kind) == self._clocks)

    def __enter__(self) -> "Workplace":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the scheduler, which lives on."""
        self._client.close(timeout=5)

    @staticmethod
    def _dask_is_quiet() -> None:
        """What dask would log of lost connections is told in our words."""
        for name in ("distributed.client", "distributed.comm", "distributed.core", "distributed.batched"):
            logging.getLogger(name).setLevel(logging.CRITICAL)

    def expect(self, modules: Sequence[str]) -> None:
        """Have these loaded in fork servers of the workers: what a run's processes would load one by one."""
        self._modules = tuple(modules)

    def described(self) -> list[str]:
        """In sentences, what machines the workers are on, and which of them clock."""
        kinds = Counter(machine_digest(kind) for kind in self._kinds.values())
        return [self._sentence(digest, count) for digest, count in kinds.most_common()]

    def _sentence(self, digest: str, count: int) -> str:
        kind = next(kind for kind in self._kinds.values() if machine_digest(kind) == digest)
        clocks = ", which clock" if digest == self._clocks else ""
        return f"workers: {count} on {kind['processor']}, {kind['cores']} cores, {kind['system']}{clocks}"

    def answers(
        self, trials: Sequence[Trial], folder: Path, at_once: int = 0, answer: Callable[..., Answered] = answer_cell
    ) -> Iterator[Record]:
        """Records as they come in, one for each trial, their files in the folder; leaving early calls back what is under way.

        Args: at_once: cells that may run at a time; 0 for all workers. answer: what a worker does for one, as `answer_cell`.
        Raises: NoScheduler, OtherPlumbline, OSError.
        """
        waiting, under_way = deque(trials), dict[Any, Trial]()
        foreseen = Counter(trial.engine for trial in trials)
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        try:
            while waiting or under_way:
                with self._reaching(folder):
                    for future, cell in self._handed_out(waiting, len(under_way), at_once, answer, foreseen):
                        under_way[future] = cell
                        future.add_done_callback(ended.put)
                done = self._next(ended, folder)
                finished = [future for future in done if future.status == "finished"]
                with self._reaching(folder):
                    results = self._client.gather(finished)
                for future, answered in zip(finished, results, strict=True):
                    yield _stored(answered, under_way[future], folder)
                for future in done:
                    cell = under_way.pop(future)
                    if future.status in ("cancelled", "lost"):
                        waiting.append(cell)
                    elif future not in finished:
                        yield _given_up(future, cell)
                    future.release()
        finally:
            self._call_back(under_way)

    def _handed_out(
        self,
        waiting: deque[Trial],
        under_way: int,
        at_once: int,
        answer: Callable[..., Answered],
        foreseen: Mapping[str, int],
    ) -> list[tuple[Any, Trial]]:
        """Some more cells, where there are few under way."""
        threads = self._client.nthreads()
        most = at_once or max(_FEWEST, _AHEAD * sum(threads.values())) if waiting else 0
        if under_way > most // 2:
            return []
        cells = [waiting.popleft() for _ in range(min(len(waiting), most - under_way))]
        workers = max(1, len(threads))
        futures = self._client.map(
            answer,
            cells,
            [foreseen[cell.engine] // workers for cell in cells],
            key=[f"cell-{cell.trial}" for cell in cells],
            batch_size=_FEWEST,
            modules=self._modules,
            run=self._run,
        )
        return list(zip(futures, cells, strict=True))

    def clocked(self, groups: Iterable[tuple[Trial, ...]], folder: Path) -> Iterator[Timing]:
        """The timings of groups, each on one host with nothing else of ours on it. Raises: NoScheduler, OtherPlumbline."""
        waiting, under_way = deque(enumerate(groups)), dict[Any, tuple[str, int, tuple[Trial, ...]]]()
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        try:
            while waiting or under_way:
                with self._reaching(folder):
                    hosts = self._clocking_hosts()
                    for future, (worker, number, group) in [*under_way.items()]:
                        if worker not in hosts.values():
                            del under_way[future]
                            self._client.cancel([future])
                            waiting.appendleft((number, group))
                    busy = {_host(worker) for worker, _, _ in under_way.values()}
                    for worker in (worker for host, worker in hosts.items() if host not in busy and waiting):
                        number, group = waiting.popleft()
                        asked = {"workers": [worker], "allow_other_workers": False, "pure": False}
                        future = self._client.submit(clock_together, group, number, self._modules, **asked)
                        under_way[future] = (worker, number, group)
                        future.add_done_callback(ended.put)
                if not under_way:
                    raise NoScheduler(f"{self.address}: no host is left of the kind that clocks; {_go_on(folder)}")
                for future in self._next(ended, folder):
                    if future in under_way and future.status == "finished":
                        with self._reaching(folder):
                            timings: list[dict[str, Any]] = future.result()
                        yield from (from_plain(Timing, each) for each in timings)
                        del under_way[future]
                    elif future in under_way and future.status == "error":
                        raise _trouble(future)
                    future.release()
        finally:
            self._call_back(under_way)

    def _clocking_hosts(self) -> dict[str, str]:
        """A worker on each host of the kind that clocks, by host."""
        workers = sorted(self._client.nthreads())
        for worker in workers:
            if worker not in self._kinds:
                self._kinds |= self._client.run(here, workers=[worker])
        return {_host(worker): worker for worker in workers if machine_digest(self._kinds[worker]) == self._clocks}

    def _next(self, ended: "queue.SimpleQueue[Any]", folder: Path) -> list[Any]:
        """The futures that have ended; some, after a wait, or none where it was in vain. Raises: NoScheduler."""
        done: list[Any] = []
        gone_since = None
        while not done:
            stop_if_asked()
            try:
                done.append(ended.get(timeout=_LISTENS))
                while not ended.empty():
                    done.append(ended.get())
            except queue.Empty:
                if self._client.status == "running":
                    return []
                gone_since = gone_since or time.monotonic()
            lost = self._client.status not in ("running", "connecting")
            if lost or (gone_since is not None and time.monotonic() - gone_since > _GONE):
                raise NoScheduler(f"{self.address}: the scheduler is gone; {_go_on(folder)}")
        return done

    @contextmanager
    def _reaching(self, folder: Path) -> Iterator[None]:
        """What dask raises where it does not reach its scheduler, in our words. Raises: NoScheduler."""
        try:
            yield
        except (OSError, CancelledError) as error:
            raise NoScheduler(f"{self.address}: the scheduler is gone ({error}); {_go_on(folder)}") from None

    def _call_back(self, under_way: Mapping[Any, Any]) -> None:
        if under_way and self._client.status == "running":
            with suppress(OSError, CancelledError):
                self._client.cancel(list(under_way))


def _go_on(folder: Path) -> str:
    return f"what finished is in {folder}; go on with the same command and --resume"


def _host(worker: str) -> str:
    """The host in a worker's address."""
    return worker.partition("://")[2].rpartition(":")[0]


def _stored(answered: Answered, trial: Trial, folder: Path) -> Record:
    """The record of a cell, its files written first. Raises: OSError; StoreError, where a file came over damaged."""
    for place, content in answered.files.items():
        if not _PLACE.fullmatch(place):
            raise StoreError(f"a worker answered with a file at {quoted(place)}, expected one of a run folder's own")
        path = folder / place
        try:
            if path.suffix == ".npz":
                require_seal(path, content)
        except Damaged as error:
            raise StoreError(f"{path}: came damaged from its worker: {error}") from None
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            disk.write_atomically(path, content)
    record = from_plain(Record, answered.record)
    if record.trial != trial.trial:
        raise StoreError(f"a worker answered trial {record.trial}, asked for {trial.trial}")
    return record


def _given_up(future: Any, trial: Trial) -> Record:
    """The record of a cell whose workers were lost. Raises: OtherPlumbline, StoreError, for anything else."""
    from distributed import KilledWorker

    if isinstance(future.exception(), KilledWorker):
        return outcome(trial, "interrupted", f"{_LOSSES + 1} workers were lost under {trial.case} on {trial.engine}")
    raise _trouble(future)


def _trouble(future: Any) -> Exception:
    error = future.exception()
    return error if isinstance(error, OtherPlumbline) else StoreError(f"a worker failed: {type(error).__name__}: {error}")
