"""A request to stop that cannot get lost, and an hour at which work under way is dropped.

Python drops an exception that a signal raises while a process is being forked, or while an object is cleared away, with a line
on stderr. Hence the request is also remembered, and the loops over trials ask.
"""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["TimeIsUp", "listen", "stop_if_asked", "until"]

_asked = False
_end = float("inf")
"""On the monotonic clock [s]."""


class TimeIsUp(Exception):
    """The hour has come that `until` was given."""


@contextmanager
def until(moment: float) -> Iterator[None]:
    """Let `stop_if_asked` raise TimeIsUp from a moment on the monotonic clock [s] on, as long as this lasts."""
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
    if time.monotonic() > _end:
        raise TimeIsUp


def _remember(_number: int, _frame: FrameType | None) -> None:
    global _asked
    _asked = True
    raise KeyboardInterrupt
