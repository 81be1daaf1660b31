"""What a night has left of its budget, and what it took: time, memory, disk."""

import os
import resource
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import psutil

__all__ = ["Budget", "bytes_of", "memory_peaks"]

CLOSING = 0.1
"""Share of a budget that is set aside for tables, report and upload, or more where a night has shown that they take it."""
MARGIN = 1.3
"""Times what they took lately at most: the report grows with what is known."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Wall time of a night, its start-up and its report included.

    Terms: seconds: of the whole, infinite for none. began: on the monotonic clock. closing [s]: set aside for the end.
    """

    seconds: float
    began: float
    closing: float

    @classmethod
    def of(cls, seconds: float, closing: float | None) -> "Budget":
        """The budget of this process, counted from its start. Args: closing [s]: what the end of an earlier night took."""
        running = max(0.0, time.time() - psutil.Process().create_time())
        aside = CLOSING * seconds if closing is None else min(max(CLOSING * seconds, MARGIN * closing), seconds / 2)
        return cls(seconds, time.monotonic() - running, aside)

    @property
    def end(self) -> float:
        """When the last answer has to be there, on the monotonic clock."""
        return self.began + self.seconds - self.closing

    def left(self) -> float:
        """Seconds until then."""
        return self.end - time.monotonic()

    def taken(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.began


def memory_peaks() -> dict[str, float]:
    """Peak resident memory [MB] of this process and of the largest of those that it waited for."""
    kinds = {"own": resource.RUSAGE_SELF, "largest_child": resource.RUSAGE_CHILDREN}
    return {name: resource.getrusage(who).ru_maxrss / 1024 for name, who in kinds.items()}


def bytes_of(paths: Iterable[Path]) -> int:
    """Bytes on the disk of files and of all that folders hold, each file once however many names it has."""
    seen: dict[tuple[int, int], int] = {}
    waiting = list(paths)
    while waiting:
        path = waiting.pop()
        if path.is_dir() and not path.is_symlink():
            waiting += [Path(entry.path) for entry in os.scandir(path)]
        elif path.exists():
            status = path.lstat()
            seen[status.st_dev, status.st_ino] = status.st_size
    return sum(seen.values())
