"""One file as `plumbline run` reads it, up to the first trial, in a process that is given up to it.

As a program: takes a JSON list of [name, arguments, environment, apart] on standard input, and prints [name, reading, peak] of
each: the most memory [MB] that its process held. What is to be read apart is read in a child, which holds what this process
holds by then.
"""

import contextlib
import functools
import io
import json
import os
import signal
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn
from unittest.mock import patch

from plumbline.harness.cli.main import main
from plumbline.harness.study.catalogue import describe_case
from plumbline.harness.study.plugins import SCENE_PREFIX
from plumbline.harness.study.study import Study

__all__ = ["LONGEST", "Reading", "peak", "read_by_command"]

YARDSTICK = "[" + "[]," * 200_000 + "[]]"
"""What is read to learn how fast this machine is: 0.6 MB of JSON."""
LONGEST = 100
"""How many times as much processor time as the yardstick one file may cost: a bound on what never ends, not on speed. The
dearest, of 17 to 28 MB, cost 12 to 18 times alone; beside a full machine what reads memory slows more than the yardstick."""
WAIT = 60.0
"""Seconds that it may cost on a clock, however many others want the processor: a pipe nobody writes to costs no time of its."""
MOST_SAID = 10_000
"""Characters that may be said of one file."""


@dataclass(frozen=True)
class Reading:
    """What became of a file: 'refused' (exit code 2), 'accepted' (the next would be the first trial), or a trouble in words."""

    ended: str
    text: str
    seconds: float


class _Hang(BaseException):
    pass


class _Accepted(BaseException):
    pass


def _stop(signal_number: int, _frame: Any) -> NoReturn:
    raise _Hang(f"more than {LONGEST} yardsticks" if signal_number == signal.SIGPROF else f"more than {WAIT:g} s on the clock")


def _up_to_here(study: Study, _folder: Path, cases: Any, adapters: Any, **_more: Any) -> NoReturn:
    """In the place of `carry_out`, and its module is not loaded: unfold all trials, describe the file's own case, run none."""
    trials = list(study.trials(cases, adapters, dict.fromkeys(adapters, "1")))
    for name in dict.fromkeys(trial.case for trial in trials if trial.case.startswith(SCENE_PREFIX)):
        describe_case(cases[name])
    raise _Accepted


CAMPAIGN = ModuleType("plumbline.harness.run.campaign")
vars(CAMPAIGN)["carry_out"] = _up_to_here


@functools.cache
def _yardstick() -> float:
    """Seconds of processor time."""

    def once() -> float:
        start = time.process_time()
        json.loads(YARDSTICK)
        return time.process_time() - start

    return min(once() for _ in range(3))


def _called(arguments: list[str]) -> str:
    signal.setitimer(signal.ITIMER_PROF, LONGEST * _yardstick())
    signal.setitimer(signal.ITIMER_REAL, WAIT)
    try:
        main(arguments)
    except SystemExit as error:
        return "refused" if error.code == 2 else f"exit code {error.code}"
    except _Accepted:
        return "accepted"
    except _Hang as hang:
        return str(hang)
    except BaseException as error:
        return f"traceback: {type(error).__name__}: {error}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
    return "ended without a word"


def read_by_command(arguments: list[str]) -> Reading:
    """What the command line makes of arguments."""
    signal.signal(signal.SIGPROF, _stop)
    signal.signal(signal.SIGALRM, _stop)
    sys.modules[CAMPAIGN.__name__] = CAMPAIGN
    said, start = io.StringIO(), time.process_time()
    with contextlib.redirect_stderr(said):
        ended = _called(arguments)
    text = said.getvalue()
    if any(not sign.isprintable() and sign not in "\n\t" for sign in text):
        ended = "control characters are printed"
    if len(text) > MOST_SAID:
        ended = f"{len(text)} characters are printed"
    return Reading(ended, text[:MOST_SAID], time.process_time() - start)


def peak() -> float:
    """The most memory [MB] that this process ever held; what getrusage says begins with that of who started it."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


def _read(name: str, arguments: list[str], environment: dict[str, str]) -> None:
    with patch.dict(os.environ, environment):
        print(json.dumps([name, asdict(read_by_command(arguments)), peak()]), flush=True)


def _read_in_a_child(*call: Any) -> None:
    child = os.fork()
    if child == 0:
        try:
            _read(*call)
        finally:
            os._exit(0)
    os.waitpid(child, 0)


if __name__ == "__main__":
    for *call, apart in json.load(sys.stdin):
        (_read_in_a_child if apart else _read)(*call)
