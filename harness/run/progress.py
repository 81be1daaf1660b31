"""Progress of long work: a bar with an estimate on a terminal, plain lines elsewhere; always on standard error."""

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Self

from plumbline.harness.intake.safe_text import LONGEST, one_line

if TYPE_CHECKING:
    from rich.progress import Progress as Bar


def in_words(low: float, high: float) -> str:
    """From how long to how long [s], to two digits, in the unit of the shorter: an estimate holds no more."""
    size, unit = next(((size, unit) for size, unit in ((1, "s"), (60, "min")) if low / size < 60), (3600, "h"))
    shortest, longest = (f"{float(f'{seconds / size:.2g}'):g}" for seconds in (low, high))
    return f"about {shortest if shortest == longest else f'{shortest} to {longest}'} {unit} left"


class Progress:
    """Counts finished pieces of work; use as a context.

    Args: left: from how long to how long [s] until all work is done, this and what comes after it; None while too little is
    known of that. Without it nothing is said of the time.
    """

    def __init__(self, title: str, total: int, left: Callable[[], tuple[float, float] | None] | None = None) -> None:
        self.title, self.total, self.done, self._left = title, total, 0, left
        self._bar: Bar | None = None
        self._said = time.monotonic()

    def __enter__(self) -> Self:
        if sys.stderr.isatty() and self.total:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                MofNCompleteColumn(),
                TextColumn("{task.fields[left]}", markup=False),
                TextColumn("{task.fields[last]}", style="dim", markup=False),
                console=Console(stderr=True),
                transient=True,
            )
            self._bar.start()
            self._task = self._bar.add_task(self.title, total=self.total, last="", left="")
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
        if now - self._said < (1.0 if self._bar is not None else 5.0) and self.done < self.total:
            if self._bar is not None:
                self._bar.update(self._task, advance=1, last=last)
            return
        self._said = now
        left = self._left and self._left()
        remaining = in_words(*left) if left else "estimating" if self._bar is not None and self._left else ""
        if self._bar is not None:
            self._bar.update(self._task, advance=1, last=last, left=remaining)
        else:
            estimate = f", {remaining}" if remaining else ""
            print(f"{self.title}: {self.done}/{self.total}{estimate} ({last})", file=sys.stderr, flush=True)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()
