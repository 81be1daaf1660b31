"""A run that ends when a person has waited long enough: its ladder first, with a first look, then what refines it.

`budget` is time on the clock on the wall, all of the run. What tables and pages take is kept for them. Of the rest, the ladder
of time steps goes on until two fifths are gone, then what tells causes and what can be foreseen begins, if half is left. Then
the ladder is clocked, coarse steps first, until four fifths are; the audit of effects has what is left. Whether a process
hangs is still told by its own CPU time.
"""

import math
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from plumbline.harness.case import Case
from plumbline.harness.case.alteration import AS_IT_IS
from plumbline.harness.run.clock_time import clock_time
from plumbline.harness.run.interrupt import UnderWay
from plumbline.harness.run.known_results import Guide
from plumbline.harness.store.record import Record
from plumbline.harness.study.trial import Trial

REFINING, SEARCHING, CLOCKING = 0.4, 0.5, 0.8
"""Shares of the time of measuring until which ladders are refined, what follows them begins, and they are clocked."""
PRESENTING, MOST_PRESENTING = 12.0, 0.25
"""Seconds that the start, tables and pages take on a quiet core, and the largest share of a budget that is kept for them."""


class Waiting(Guide):
    """Terms: measuring [s]: of the budget, before tables and pages are made. look: is told once of the first steps of all
    ladders, as soon as they are answered. over: did the time run out?"""

    sitting = 5.0

    def __init__(self, budget: float, cases: Mapping[str, Case], look: Callable[[Sequence[Record]], object]) -> None:
        self.begun, self.over = time.monotonic(), False
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

    def broken_off(self, under_way: Sequence[UnderWay]) -> None:
        """The time was up."""
        del under_way
        self.over = True

    def asked(self, trials: Collection[str], records: Mapping[str, Record]) -> Collection[str]:
        """What was answered: nobody waited for the rest."""
        return [trial for trial in trials if trial in records] if self.over else trials
