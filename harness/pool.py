"""Accuracy runs in processes of their own (pebble): a crash, a hang or a leak costs one trial and is a record."""

import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from pathlib import Path

from pebble import ProcessExpired, concurrent

from harness import discover
from harness.interrupt import stop_if_asked
from harness.record import Record
from harness.run import outcome
from harness.study import Trial
from harness.worker import context, isolated_trial

__all__ = ["run_isolated"]

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
        return stream.read().decode("utf-8", errors="replace").strip()


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


def _late(trial: Trial, log: Path) -> Record:
    return outcome(trial, "timeout", f"deadline of {trial.experiment.deadline:g} s passed", _tail(log))


def _expired(trial: Trial, error: ProcessExpired, log: Path) -> Record:
    detail = _tail(log)
    code = error.exitcode
    if "bad_alloc" in detail or "MemoryError" in detail:
        return outcome(trial, "oom", f"more than {trial.experiment.memory:g} MB asked for", detail)
    if code == -signal.SIGALRM:
        return _late(trial, log)
    if code is not None and code < 0:
        return outcome(trial, "crashed", f"killed by {signal.Signals(-code).name}", detail)
    return outcome(trial, "crashed", f"process ended with exit code {code} and no result", detail)


def _record(trial: Trial, future: Future[Record], log: Path) -> Record:
    try:
        return future.result()
    except ProcessExpired as error:
        return _expired(trial, error, log)
    except TimeoutError:
        return _late(trial, log)
    except CancelledError:
        return outcome(trial, "interrupted", "the run was stopped")
    except Exception as error:
        return outcome(trial, "crashed", f"{type(error).__name__}: {error}"[:2000], _tail(log))


def run_isolated(trials: Sequence[Trial], folder: Path, workers: int) -> Iterator[Record]:
    """Records as they come in, one for each trial; leaving the iterator early stops all children."""
    logs = folder / "logs"
    logs.mkdir(exist_ok=True)
    waiting = list(reversed(trials))
    running: dict[Future[Record], Trial] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                trial = waiting.pop()
                log = logs / f"{trial.trial}.log"
                log.unlink(missing_ok=True)
                patience = trial.experiment.deadline + discover.adapter(trial.engine).compile_allowance
                run = concurrent.process(timeout=patience, mp_context=context())(isolated_trial)
                running[run(trial, folder, log)] = trial
            done, _ = wait(running, timeout=_LISTENS, return_when=FIRST_COMPLETED)
            stop_if_asked()
            for future in done:
                trial = running.pop(future)
                log = logs / f"{trial.trial}.log"
                record = _record(trial, future, log)
                _trim(log, record)
                yield record
    finally:
        for future in running:
            future.cancel()
        wait(running, timeout=10.0)
        if not any(logs.iterdir()):
            logs.rmdir()
