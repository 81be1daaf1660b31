"""What a night has left of its budget, and what it took: time, memory, disk; and how long it will take to close."""

import math
import os
import resource
import time
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

CLOSING = 0.1
"""Share of a budget that is set aside for tables, report and upload, or more where a night has shown that they take it."""
UNKNOWN = 0.15
"""That share of the first night: 80 to 127 s of a quarter of an hour were seen, on an idle and on a loaded machine."""
MARGIN = 1.3
"""Times what is foreseen: what a night tells, and so writes, is another every night."""


@dataclass(slots=True)
class Budget:
    """Wall time of a night, its start-up and its report included.

    Terms: seconds: of the whole, infinite for none. began: on the monotonic clock. closings: of the last nights, how many
    answers each had and how long its end took [s], as if nothing had slowed it. closing [s]: set aside for the end, more as the
    night stores more or turns out slow.
    """

    seconds: float
    began: float
    closings: tuple[tuple[int, float], ...] = ()
    closing: float = 0.0

    def __post_init__(self) -> None:
        self.set_aside(0, 1.0)

    @classmethod
    def of(cls, seconds: float, plans: Iterable[Mapping[str, Any]]) -> "Budget":
        """The budget of this process, counted from its start. Args: plans: of the last nights, when they were whole."""
        running = max(0.0, time.time() - psutil.Process().create_time())
        ends = ((plan["answers"], plan["seconds"]["closing"] / plan["seconds"].get("slow", 1.0)) for plan in plans)
        return cls(seconds, time.monotonic() - running, tuple(ends))

    def set_aside(self, answers: int, slow: float) -> None:
        """Set time aside for closing a night that has so many answers and is so much slower than foreseen; half at most.

        Tables and pages take time for each answer: as long as the longest of the last ends, more where there are more answers.
        """
        if math.isfinite(self.seconds):
            ends = (took * max(1.0, answers / max(before, 1)) for before, took in self.closings)
            foreseen = MARGIN * slow * max(ends) if self.closings else UNKNOWN * self.seconds
            self.closing = min(max(CLOSING * self.seconds, foreseen), self.seconds / 2)

    @property
    def end(self) -> float:
        """When the last answer has to be there, on the monotonic clock."""
        return self.began + self.seconds - self.closing

    def left(self) -> float:
        """Seconds until then."""
        return self.end - time.monotonic()

    def rest(self) -> float:
        """Seconds until the whole is over."""
        return self.seconds - self.taken()

    def taken(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.began


def memory_peaks() -> dict[str, float]:
    """Peak resident memory [MB] of this process and of the largest of those that it waited for."""
    kinds = {"own": resource.RUSAGE_SELF, "largest_child": resource.RUSAGE_CHILDREN}
    return {name: resource.getrusage(who).ru_maxrss / 1024 for name, who in kinds.items()}


def bytes_of(paths: Iterable[Path], *, shared: bool = True) -> int:
    """Bytes on the disk of files and of all that folders hold, each file once however many names it has. Args: shared: also of
    files that have a name elsewhere."""
    seen: dict[tuple[int, int], tuple[int, int]] = {}
    names: Counter[tuple[int, int]] = Counter()
    waiting = list(paths)
    while waiting:
        path = waiting.pop()
        if path.is_dir() and not path.is_symlink():
            waiting += [Path(entry.path) for entry in os.scandir(path)]
        elif path.exists():
            status = path.lstat()
            file = status.st_dev, status.st_ino
            seen[file] = status.st_size, status.st_nlink
            names[file] += 1
    return sum(size for file, (size, links) in seen.items() if shared or names[file] >= links)
