"""How much memory a process takes, looked at from outside.

Nothing is refused to an engine: code that is refused memory may raise, abort, or read address zero, and nobody could tell that
from a fault of its own. It is let grow, and killed by who watches it once it has taken more than it may; that one knows why.
Where the system itself is short of memory, it kills; it counts how often, and a process that was watched is the first to go.

A request to stop that cannot get lost, and an hour at which work under way is dropped.

Python drops an exception that a signal raises while a process is being forked, or while an object is cleared away, with a line
on stderr. Hence the request is also remembered, and the loops over trials ask.
"""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

import psutil

if TYPE_CHECKING:
    from plumbline.harness.study.trial import Trial

LOOKS = 0.05
"""Seconds between looks at a process; what fills a gigabyte a second fills 50 MB in that time."""
_LOOKS_ROUND = 20
"""Looks at a process for each one at those that it started, which are to be searched for."""
_MB = 2**20
_COUNTS = ("/proc/vmstat", "/sys/fs/cgroup/memory.events")
_SCORE = Path("/proc/self/oom_score_adj")


def be_killed_first() -> None:
    """Where the system has to kill a process for want of memory, let it be this one."""
    with suppress(OSError):
        _SCORE.write_text("1000")


def kills_for_memory() -> int:
    """How often the system has killed for want of memory, by its own counts; 0 where it keeps none."""
    kills = 0
    for path in _COUNTS:
        with suppress(OSError, ValueError):
            lines = Path(path).read_text(encoding="ascii").splitlines()
            kills += sum(int(line.split()[1]) for line in lines if line.startswith("oom_kill "))
    return kills


class MemoryWatch:
    """Kills a process that takes more than `most` [MB] from now on, with what the processes hold that it starts.

    Terms: taken [MB]: what it had taken then; 0.0 where it was not killed. Of the process addresses count, of those that it
    starts what is in memory and theirs alone.
    """

    def __init__(self, pid: int, most: float, looks: float = LOOKS) -> None:
        self.taken = 0.0
        self._most, self._looks, self._done = most, looks, threading.Event()
        with suppress(psutil.NoSuchProcess):
            self._process = psutil.Process(pid)
            self._before = self._process.memory_info().vms
            threading.Thread(target=self._watch, daemon=True).start()

    def stop(self) -> None:
        """Look no more."""
        self._done.set()

    def _watch(self) -> None:
        number, others = 0, 0.0
        with suppress(psutil.Error):
            while not self._done.wait(self._looks):
                number += 1
                if number % _LOOKS_ROUND == 0:
                    others = self._of_others()
                taken = (self._process.memory_info().vms - self._before) / _MB + others
                if taken > self._most:
                    self.taken = taken
                    started = self._process.children(recursive=True)
                    self._process.kill()
                    for other in started:
                        with suppress(psutil.Error):
                            other.kill()
                    return

    def _of_others(self) -> float:
        """What the processes hold that were started in this one [MB]."""
        occupied = 0.0
        for other in self._process.children(recursive=True):
            with suppress(psutil.Error):
                info = other.memory_info()
                occupied += (info.rss - getattr(info, "shared", 0)) / _MB
        return occupied


def _never() -> float:
    return math.inf


_asked = False
_end: Callable[[], float] = _never
"""On the monotonic clock [s]."""


@dataclass(frozen=True, slots=True)
class UnderWay:
    """A trial without an answer yet. Terms: seconds: since its process was asked for one."""

    trial: "Trial"
    seconds: float


class TimeIsUp(Exception):
    """The hour has come that `until` was given. Terms: under_way: what was asked and had not answered then."""

    under_way: tuple[UnderWay, ...] = ()


def hour() -> float:
    """When `stop_if_asked` begins to raise TimeIsUp, on the monotonic clock [s]; infinite for never."""
    return _end()


@contextmanager
def naming(trials: Iterable[tuple["Trial", float]]) -> Iterator[None]:
    """Have a TimeIsUp that leaves this say that these were waited for. Args: each with when it was asked, as by `hour`."""
    try:
        yield
    except TimeIsUp as up:
        up.under_way = tuple(UnderWay(trial, time.monotonic() - asked) for trial, asked in trials)
        raise


@contextmanager
def until(moment: Callable[[], float]) -> Iterator[None]:
    """Let `stop_if_asked` raise TimeIsUp from a moment on the monotonic clock [s] on, as long as this lasts; it may move."""
    global _end  # as what signals ask for: one run has a process
    before, _end = _end, moment
    try:
        yield
    finally:
        _end = before


def listen() -> None:
    """Take Ctrl-C and SIGTERM as requests to stop: KeyboardInterrupt at once, or else at the next `stop_if_asked`."""
    global _asked  # signals belong to the process, and so does what they ask for
    _asked = False
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _remember)


def stop_if_asked() -> None:
    """Raises: KeyboardInterrupt, where a request to stop has come since `listen`. TimeIsUp, see `until`."""
    if _asked:
        raise KeyboardInterrupt
    if time.monotonic() > _end():
        raise TimeIsUp


def _remember(_number: int, _frame: FrameType | None) -> None:
    global _asked
    _asked = True
    raise KeyboardInterrupt
