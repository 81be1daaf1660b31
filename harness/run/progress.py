"""Progress of long work: a bar with an estimate on a terminal, plain lines elsewhere; always on standard error."""

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from harness.intake.safe_text import LONGEST, one_line

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

__all__ = ["Progress"]


class Progress:
    """Counts finished pieces of work; use as a context."""

    def __init__(self, title: str, total: int) -> None:
        self.title, self.total, self.done = title, total, 0
        self._bar: Bar | None = None
        self._started = self._said = time.monotonic()

    def __enter__(self) -> Self:
        if sys.stderr.isatty() and self.total:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                TextColumn("{task.fields[last]}", style="dim", markup=False),
                console=Console(stderr=True),
                transient=True,
            )
            self._bar.start()
            self._task = self._bar.add_task(self.title, total=self.total, last="")
        return self

    def advance(self, last: str) -> None:
        """One more piece is done; `last` names it."""
        self.done += 1
        last = one_line(last, LONGEST)
        if self._bar is not None:
            self._bar.update(self._task, advance=1, last=last)
            return
        now = time.monotonic()
        if now - self._said >= 5.0 or self.done == self.total:
            self._said = now
            left = (now - self._started) / self.done * (self.total - self.done)
            # The first pieces pay for what all share: engines that are loaded, and one that compiles itself.
            remaining = f", about {left:.0f} s left" if self.done >= self.total / 10 else ""
            print(f"{self.title}: {self.done}/{self.total}{remaining} ({last})", file=sys.stderr, flush=True)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()
