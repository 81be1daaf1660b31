"""Progress of long work: a bar with an estimate on a terminal, plain lines elsewhere; always on standard error."""

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Self

from harness.intake.safe_text import LONGEST, one_line

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

__all__ = ["Progress", "in_words"]

FIRST = 0.05
"""Share of the pieces before which nothing is said of the time that is left: too little is known."""


def in_words(seconds: float) -> str:
    """About how long, to two digits: an estimate holds no more."""
    if seconds < 99.5:
        return f"{float(f'{seconds:.2g}'):.0f} s"
    minutes = seconds / 60
    return f"{minutes:.2g} min" if minutes < 99.5 else f"{minutes / 60:.2g} h"


class Progress:
    """Counts finished pieces of work; use as a context.

    Args: left: seconds until all work is done, this and what comes after it; None while that is not known.
    """

    def __init__(self, title: str, total: int, left: Callable[[], float | None] = lambda: None) -> None:
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
        left = self._left() if self.done >= FIRST * self.total else None
        remaining = "" if left is None else f"about {in_words(left)} left"
        if self._bar is not None:
            self._bar.update(self._task, advance=1, last=last, left=remaining)
        else:
            said = f", {remaining}" if remaining else ""
            print(f"{self.title}: {self.done}/{self.total}{said} ({last})", file=sys.stderr, flush=True)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()
