"""One program in a process of its own: bounded in time and in what it writes, and ended with all that it started.

What it prints goes to files, so that one that it started, and that holds on to its streams, keeps nobody waiting.
"""

import ctypes
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import IO, Self

from plumbline.harness.intake.deadline import Deadline

_LARGEST_FILE = 512 * 2**20
"""Bytes that it may write to a file."""
_READ = 2**20
"""Bytes that are read of what it printed, from the end."""
_LOOKS = 0.02
"""Seconds between looks at it."""
_DYING = 5.0
"""Seconds that what was killed may take to be gone: the system ends it when it gets to it."""
_PR_SET_PDEATHSIG = 1
"""From linux/prctl.h: the signal that a process gets when the one that forked it is gone."""
_LIBRARY = ctypes.CDLL(None) if sys.platform == "linux" else None


def absolute(folders: Iterable[str]) -> list[str]:
    """Folders that an interpreter looks into, as one elsewhere finds them; without those of a present folder that is gone."""
    paths = []
    for folder in folders:
        with suppress(FileNotFoundError):
            paths.append(str(Path(folder).absolute()))
    return paths


def named_signal(number: int) -> str:
    """A signal's name; those of real time have none of their own."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


@dataclass(frozen=True, slots=True)
class Ended:
    """How a program ended.

    Terms: code: its exit code, below zero for the signal that killed it; None where it was late, and was killed for it.
    allowed [s]: what it was given. answer: what it wrote to the file that it was handed. out, err: the end of what it printed.
    """

    code: int | None
    allowed: float
    answer: bytes
    out: bytes
    err: bytes

    @property
    def how(self) -> str:
        """In words, as they follow the name of the program."""
        if self.code is None:
            return f"did not end within {self.allowed:g} s"
        return f"was killed by {named_signal(-self.code)}" if self.code < 0 else f"ended with exit code {self.code}"

    @property
    def last_words(self) -> str:
        """The last line that it printed, of its errors where there are any; '' for none."""
        lines = (self.err.strip() or self.out.strip()).decode("utf-8", "replace").splitlines()
        return lines[-1].strip() if lines else ""


class Bounded:
    """A program that runs. A context: at its end it is gone, with what it started.

    Terms: answer: the file that it is handed as its last argument, where it is to have one.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        answers: bool = False,
        order: bytes = b"",
        env: Mapping[str, str] | None = None,
        cwd: str | Path | None = None,
    ) -> None:
        """Args: order: what it reads on its standard input. answers: is it handed a file to write to? Raises: OSError."""
        self._folder = TemporaryDirectory(prefix="plumbline-", ignore_cleanup_errors=True)
        self.answer = Path(self._folder.name) / "answer"
        self._out, self._err = TemporaryFile(), TemporaryFile()  # noqa: SIM115  # closed with the context
        self._allowed, self._late = 0.0, False
        try:
            with TemporaryFile() as stdin:
                stdin.write(order)
                stdin.seek(0)
                self._process = subprocess.Popen(
                    [*command, *([str(self.answer)] if answers else [])],
                    stdin=stdin,
                    stdout=self._out,
                    stderr=self._err,
                    env=env,
                    cwd=cwd,
                    start_new_session=True,
                    preexec_fn=_as_child,  # one call to the system, of a library that is loaded
                )
        except BaseException:
            self._folder.cleanup()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        for stream in (self._out, self._err):
            stream.close()
        self._folder.cleanup()

    def wait(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Wait until it has ended, or something else is so. Returns: False where that takes longer than it may, in CPU time.

        It is not ended then.
        """
        deadline, self._allowed = Deadline(self._process.pid, seconds), seconds
        while self._process.poll() is None and not until():
            if deadline.passed():
                self._late = True
                return False
            time.sleep(_LOOKS)
        return True

    @property
    def running(self) -> bool:
        """Has it not ended yet?"""
        return self._process.poll() is None

    def ended(self) -> Ended:
        """How it ended; where it runs, it is ended first, as late."""
        code = self._process.poll()
        self._end()
        content = self.answer.read_bytes() if self.answer.is_file() else b""
        return Ended(None if self._late else code, self._allowed, content, _tail(self._out), _tail(self._err))

    def _end(self) -> None:
        end_with_started(self._process.pid, running=self.running)
        self._process.wait()


def bounded(
    command: Sequence[str],
    seconds: float,
    *,
    answers: bool = False,
    order: bytes = b"",
    env: Mapping[str, str] | None = None,
    cwd: str | Path | None = None,
) -> Ended:
    """Run a program to its end, or for so many seconds of CPU time. Args: as of `Bounded`. Raises: OSError."""
    with Bounded(command, answers=answers, order=order, env=env, cwd=cwd) as program:
        program.wait(seconds)
        return program.ended()


def end_with_started(pid: int, *, running: bool) -> None:
    """Kill a process, its group, and, as long as it runs, every other one that was started in it; those are gone then."""
    import psutil  # late: a listing starts no program

    started: list[psutil.Process] = []
    if running:
        with suppress(psutil.Error):
            process = psutil.Process(pid)
            started = [process, *process.children(recursive=True)]
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    for each in started:
        with suppress(psutil.Error):
            each.kill()
    late = time.monotonic() + _DYING
    for each in started[1:]:  # the process itself is waited for by whoever started it
        with suppress(psutil.Error):
            while each.is_running() and each.status() != psutil.STATUS_ZOMBIE and time.monotonic() < late:
                time.sleep(_LOOKS / 10)


def end_with_parent() -> None:
    """Whoever forked this process is killed: it goes along."""
    if _LIBRARY is not None:
        _LIBRARY.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def limit_files() -> None:
    """No image of this process is left where it dies, and it writes no file that could fill the disk."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = _LARGEST_FILE if hard == resource.RLIM_INFINITY else min(hard, _LARGEST_FILE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


def _as_child() -> None:
    end_with_parent()
    limit_files()


def _tail(stream: IO[bytes]) -> bytes:
    stream.seek(max(0, stream.seek(0, os.SEEK_END) - _READ))
    return stream.read()
