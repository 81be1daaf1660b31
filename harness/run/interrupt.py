"""A request to stop that cannot get lost.

Python drops an exception that a signal raises while a process is being forked, or while an object is cleared away, with a line
on stderr. Hence the request is also remembered, and the loops over trials ask.
"""

import signal
from types import FrameType

__all__ = ["listen", "stop_if_asked"]

_asked = False


def listen() -> None:
    """Take Ctrl-C and SIGTERM as requests to stop: KeyboardInterrupt at once, or else at the next `stop_if_asked`."""
    global _asked  # signals belong to the process, and so does what they ask for
    _asked = False
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _remember)


def stop_if_asked() -> None:
    """Raises: KeyboardInterrupt, where a request to stop has come since `listen`."""
    if _asked:
        raise KeyboardInterrupt


def _remember(_number: int, _frame: FrameType | None) -> None:
    global _asked
    _asked = True
    raise KeyboardInterrupt
