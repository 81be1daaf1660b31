"""Deadlines in CPU time, so that a busy machine makes no process late."""

import time
from contextlib import suppress

import psutil

CROWDED = 10.0
"""Times the deadline that a process may take by the clock on the wall: one that gets a tenth of a core is given up there."""
IDLE = 0.01
"""Of a core, below which a process waits for something that does not come, unless it waits for a core itself."""
_WANTS = (psutil.STATUS_RUNNING, psutil.STATUS_DISK_SLEEP, psutil.STATUS_WAKING)
"""What a process is in that would go on at once if the machine let it."""
_LOOKS = 0.05
"""Seconds between looks at least."""


def _own_seconds(pid: int) -> float:
    """CPU time of a process alone, which costs a thirtieth of a look at those that it started; 0 of one that is gone."""
    with suppress(psutil.Error):
        times = psutil.Process(pid).cpu_times()
        return float(times.user + times.system)
    return 0.0


def _cpu_seconds(pid: int) -> float:
    """CPU time of a process and of those that it started; 0 of one that is gone."""
    spent = 0.0
    with suppress(psutil.Error):
        process = psutil.Process(pid)
        for each in (process, *process.children(recursive=True)):
            with suppress(psutil.Error):
                times = each.cpu_times()
                spent += times.user + times.system
    return spent


def _kept_waiting(pid: int) -> bool:
    """Would a process, or one that it started, go on if the machine let it?"""
    with suppress(psutil.Error):
        process = psutil.Process(pid)
        for each in (process, *process.children(recursive=True)):
            with suppress(psutil.Error):
                if each.status() in _WANTS:
                    return True
    return False


class Deadline:
    """A process may take so many seconds of CPU time from now on.

    It is looked at once they have passed on the wall, and again when what is left of them may have. It is late where it has
    taken them, where it was idle since the last look and still is, and after CROWDED times as long in any case. It is made for
    each answer under the clock, so that it looks at no more than the process itself until then: what others that it had started
    before have taken counts too, which makes nobody late before the wall clock has.

    Terms: until [s]: of the monotonic clock; before that nobody needs to look.
    """

    def __init__(self, pid: int, seconds: float) -> None:
        self._pid, self._seconds = pid, seconds
        self._since = self._looked = time.monotonic()
        self._first = self._spent = _own_seconds(pid)
        self.until = self._since + seconds

    def passed(self) -> str:
        """Why the process is late; nothing where it is not."""
        now = time.monotonic()
        if now <= self.until:
            return ""
        spent = _cpu_seconds(self._pid)
        share, left = (spent - self._spent) / (now - self._looked), self._seconds - (spent - self._first)
        end = self._since + CROWDED * self._seconds
        self._spent, self._looked = spent, now
        self.until = min(end, now + max(_LOOKS, left))
        if left <= 0:
            return "all of it CPU time"
        if share < IDLE and not _kept_waiting(self._pid):
            return "and it did nothing"
        return f"{CROWDED:g} times over, of which it got {spent - self._first:.3g} s" if now >= end else ""
