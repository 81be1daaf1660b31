"""What may steer a run beyond its study: what is known already, in which order it goes, where its searches begin."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

from plumbline.harness.run.interrupt import UnderWay
from plumbline.harness.store.record import Record, Timing
from plumbline.harness.study.trial import Trial


class Guide:
    """A run as it goes by itself; a history overrides what it steers.

    Terms: sitting: for how long [s] questions are clocked in one sitting; 0 for one at a time.
    """

    sitting = 60.0

    def end(self) -> float:
        """When the run is broken off, on the monotonic clock [s]; infinite for never."""
        return math.inf

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """The trials in parts, each of which is answered, searched on and clocked before the next one begins."""
        yield list(trials)

    def known(self, trial: Trial) -> Record | None:
        """The record of an answer that is not computed again; None where there is none."""
        del trial
        return None

    def alike(self, trial: Trial) -> Record | None:
        """A known answer of the trial's motion, whose trajectory lies in the run's folder and is judged anew; None for none."""
        del trial
        return None

    def answered(self, trial: Trial, record: Record) -> Record:
        """Take in an answer that was computed. Returns: the record to be kept."""
        del trial
        return record

    def beside(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> list[Trial]:
        """Trials of the same searches that earlier ones ended at."""
        del trials, records
        return []

    def searches(self, trial: Trial, records: Mapping[str, Record]) -> bool:
        """Is a trial run that a search proposes?"""
        del trial, records
        return True

    def clocks(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> Collection[str]:
        """The names of those trials, due for the clock, that are clocked."""
        del records
        return {trial.trial for trial in trials}

    def clocked(self, trials: Sequence[Trial]) -> None:
        """Take note that these were clocked side by side, just now."""

    def doubts(self, timings: Sequence[Timing]) -> bool:
        """Are these, of what was clocked side by side just now, clocked once more?"""
        del timings
        return False

    def broken_off(self, under_way: Sequence[UnderWay]) -> None:
        """Take note that time was up, and what had no answer yet."""

    def asked(self, trials: Collection[str], records: Mapping[str, Record]) -> Collection[str]:
        """Of all trials of a study, those that the run comprised in the end."""
        del records
        return trials


class Waited(Guide):
    """A run that a person waits for. Terms: over: did the time run out? What has no answer then is left out."""

    sitting = 5.0
    over = False

    def broken_off(self, under_way: Sequence[UnderWay]) -> None:
        """The time was up."""
        del under_way
        self.over = True

    def asked(self, trials: Collection[str], records: Mapping[str, Record]) -> Collection[str]:
        """What was answered, where the time was up."""
        return [trial for trial in trials if trial in records] if self.over else trials


UNGUIDED = Guide()
"""A run without a history."""
