"""Progress of long work: a bar on a terminal, plain lines elsewhere; always on standard error."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from plumbline.harness.intake.safe_text import LONGEST, one_line

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

QUIET = 5.0
"""Seconds between two plain lines."""
_BEGUN = time.monotonic()
"""When this process began to report: what a person has waited since."""


def elapsed(seconds: float) -> str:
    """'47 s', '3 min 20 s', '1 h 5 min'."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole // 60 % 60} min"


def since_begun() -> float:
    """Seconds that a person has waited for this process."""
    return time.monotonic() - _BEGUN


class Progress:
    """Counts finished pieces of work, with the time since the process began to report; use as a context."""

    def __init__(self, title: str, total: int) -> None:
        self.title, self.total, self.done = title, total, 0
        self._bar: Bar | None = None
        self._said = time.monotonic()

    def __enter__(self) -> Self:
        if sys.stderr.isatty() and self.total:
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                TextColumn("{task.completed:.0f} of {task.total:.0f}, {task.fields[elapsed]}", markup=False),
                TextColumn("{task.fields[last]}", style="dim", markup=False),
                console=Console(stderr=True),
                transient=True,
            )
            self._bar.start()
            self._task = self._bar.add_task(self.title, total=self.total, last="", elapsed="0 s")
        return self

    def tell(self, now: str) -> None:
        """What is being done, while nothing ends: on a terminal alone."""
        if self._bar is not None:
            self._bar.update(self._task, last=one_line(now, LONGEST))

    def advance(self, last: str) -> None:
        """One more piece is done; `last` names it."""
        self.done += 1
        last = one_line(last, LONGEST)
        now = time.monotonic()
        since = elapsed(since_begun())
        if self._bar is not None:
            self._bar.update(self._task, advance=1, last=last, elapsed=since)
        elif now - self._said >= QUIET or self.done >= self.total:
            self._said = now
            print(f"{self.title}: {self.done} of {self.total}, {since} ({last})", file=sys.stderr, flush=True)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()
