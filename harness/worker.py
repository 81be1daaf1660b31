"""Child processes: how they are confined in memory and output, how they end, and what one does with a trial."""

import ctypes
import os
import resource
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from multiprocessing.process import BaseProcess
from pathlib import Path

import psutil

from harness import discover
from harness.adapter import Adapter, SettingsError, Unavailable, Unsupported
from harness.bench import Bench, rough_cost_beside
from harness.case import Case
from harness.endure import endure
from harness.journal import StoreError
from harness.record import Record, Status
from harness.run import outcome, run_trial
from harness.study import Trial

__all__ = ["confine", "end", "exit_code", "isolated_trial", "roughly_clocked"]

_LEAVES = 3.0
"""Seconds that a process may take to end after its last word."""
_LARGEST_FILE = 512 * 2**20
"""Bytes; what an engine prints beyond is lost, so that a flood cannot fill the disk."""
_PR_SET_PDEATHSIG = 1
"""From linux/prctl.h: the signal that a process gets when the one that forked it is gone."""


def exit_code(process: BaseProcess) -> int | None:
    """How a process ended whose pipe has broken: that comes before the fork server has told the code.

    It is waited for; a process that lives on after its last word is killed.
    """
    process.join(_LEAVES)
    if process.exitcode is None:
        end(process)
    return process.exitcode


def end(process: BaseProcess) -> None:
    """End a process that was confined, and every other one that was started in it and stayed in its group."""
    if process.is_alive():
        process.kill()
        process.join()
    with suppress(ProcessLookupError, PermissionError):
        if process.pid:
            os.killpg(process.pid, signal.SIGKILL)


def confine(memory: float, log: Path) -> None:
    """Limit the growth of this process to `memory` [MB] of addresses and send its output to `log`.

    An interrupt is the parent's affair; a parent that is killed takes this process along. What is started in it is of its
    group, which ends with it.
    """
    os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    stream = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    os.close(stream)
    limit = psutil.Process().memory_info().vms + int(memory * 2**20)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_LARGEST_FILE, _LARGEST_FILE))


def _compile(trial: Trial, case: Case, adapter: Adapter) -> None:
    """Let an engine compile itself, and have this process killed by SIGALRM once the deadline has passed after that.

    The alarm needs no help from Python, so that code which holds the interpreter does not outlive it.
    """
    # What is wrong with the scene or the settings is for `build` to say.
    with suppress(Unsupported, Unavailable, SettingsError):
        adapter.compile(trial.scene(case), trial.settings)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, trial.experiment.deadline)


def isolated_trial(trial: Trial, folder: Path, log: Path) -> Iterator[Record]:
    """The accuracy run of a trial, whatever its Python code raises; the process may still die under it.

    What a sweep goes on from comes once more, with its rough cost: if the clock fails, the answer is safe.
    """
    confine(trial.experiment.memory, log)
    try:
        case, adapter = discover.case(trial.case), discover.adapter(trial.engine)
        if adapter.compile_allowance > 0:
            _compile(trial, case, adapter)
        record = endure(trial, case, adapter, folder) if trial.members > 1 else run_trial(trial, case, adapter, folder)
    except StoreError as error:  # ours, not the engine's
        record = outcome(trial, "interrupted", str(error))
    except MemoryError:
        record = outcome(trial, "oom", f"more than {trial.experiment.memory:g} MB asked for")
    except Exception as error:
        status: Status = "oom" if "bad_alloc" in str(error) else "crashed"
        record = outcome(trial, status, f"{type(error).__name__}: {error}"[:2000], traceback.format_exc()[-4000:])
    yield record
    if roughly_clocked(trial, record):
        yield _with_rough_cost(record, trial, case, adapter)


def roughly_clocked(trial: Trial, record: Record) -> bool:
    """Is a rough cost wanted of what came of a trial?"""
    return bool(trial.experiment.sweep) and trial.members == 1 and bool(record.measurements)


def _with_rough_cost(record: Record, trial: Trial, case: Case, adapter: Adapter) -> Record:
    """The record with its rough cost, and with that over the cost of the first track that runs at the case's own step."""
    said: list[str] = []
    for track, settings in adapter.tracks.items():
        yardstick = trial.probing(case, track=track, settings=settings.with_dt(case.dt))
        own, beside = (Bench(case, adapter, one, settled=False) for one in (trial, yardstick))
        try:
            cost, ratio = rough_cost_beside(own, beside)
            return replace(record, rough_cost=cost, rough_ratio=ratio)
        except Exception as error:
            said.append(f"{track}: {type(error).__name__}: {error}")
    return replace(record, warnings=(*record.warnings, f"rough cost: none, beside {'; '.join(said)}"))
