"""A run that ends when a person has waited long enough: its ladder first, with a first look, then what refines it; and the
progress of long work, always on standard error.

`budget` is time on the clock on the wall, all of the run. What tables and pages take is kept for them. Of the rest, the ladder
of time steps goes on until two fifths are gone, then what tells causes and what can be foreseen begins, if half is left. Then
the ladder is clocked, coarse steps first, until four fifths are; the audit of effects has what is left. Whether a process
hangs is still told by its own CPU time.
"""

import math
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from plumbline.harness.case import Case
from plumbline.harness.case.alteration import AS_IT_IS
from plumbline.harness.intake.safe_text import LONGEST, one_line
from plumbline.harness.run.known_results import Waited
from plumbline.harness.run.timing_protocol import clock_time
from plumbline.harness.store.record import Record
from plumbline.harness.study.trial import Trial

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

REFINING, SEARCHING, CLOCKING = 0.4, 0.5, 0.8
"""Shares of the time of measuring until which ladders are refined, what follows them begins, and they are clocked."""
PRESENTING, MOST_PRESENTING = 12.0, 0.25
"""Seconds that the start, tables and pages take on a quiet core, and the largest share of a budget that is kept for them."""


class Waiting(Waited):
    """Terms: measuring [s]: of the budget, before tables and pages are made. look: is told once of the first steps of all
    ladders, as soon as they are answered."""

    def __init__(self, budget: float, cases: Mapping[str, Case], look: Callable[[Sequence[Record]], object]) -> None:
        self.begun = time.monotonic()
        self.measuring = budget - min(PRESENTING, MOST_PRESENTING * budget)
        self._cases, self._look = cases, look
        self._ladder: set[str] = set()
        self._first: dict[str, Record | None] = {}

    def end(self) -> float:
        """When measuring is over; never before the first look, without which there is no answer at all."""
        return math.inf if self._first else self.begun + self.measuring

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """The ladders, which are looked at first, and then the rest, where there is time."""
        ladder = [trial for trial in trials if trial.experiment.refine is not None]
        self._ladder = {trial.trial for trial in ladder}
        yield from (batch for batch in (ladder, [trial for trial in trials if trial.trial not in self._ladder]) if batch)

    def known(self, trial: Trial) -> Record | None:
        """Nothing is; but this one is going to be answered now."""
        if trial.trial in self._ladder:
            self._first[trial.trial] = None
        return None

    def answered(self, trial: Trial, record: Record) -> Record:
        """Note an answer, and look once all first steps have one."""
        if trial.trial in self._first:
            self._first[trial.trial] = record
            if all(self._first.values()):
                self._look([each for each in self._first.values() if each is not None])
                self._first = {}
        return record

    def searches(self, trial: Trial, records: Mapping[str, Record]) -> bool:
        """Ladders are refined for a part of the time; what follows them may begin a little later."""
        del records
        share = REFINING if trial.alteration == AS_IT_IS else SEARCHING
        return time.monotonic() < self.begun + share * self.measuring

    def clocks(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> Collection[str]:
        """Those that fit into their share of the time, coarse steps first."""
        left = self.begun + CLOCKING * self.measuring - time.monotonic()
        if trials and trials[0].experiment.refine is None:
            left = self.begun + self.measuring - time.monotonic()
        chosen = []
        for trial in sorted(trials, key=lambda trial: -trial.settings.dt):
            left -= clock_time(trial, records[trial.trial], self._cases[trial.case])
            if left > 0:
                chosen.append(trial.trial)
        return chosen


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
