"""A request to stop that cannot get lost, and an hour at which work under way is dropped.

Python drops an exception that a signal raises while a process is being forked, or while an object is cleared away, with a line
on stderr. Hence the request is also remembered, and the loops over trials ask.
"""

import math
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plumbline.harness.study.trial import Trial


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
