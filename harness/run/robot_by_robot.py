"""A run that goes robot by robot until its time is up: what is there by then has whole robots."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from plumbline.harness.run.interrupt import UnderWay
from plumbline.harness.run.known_results import Guide
from plumbline.harness.store.record import Record
from plumbline.harness.study.trial import Trial


class RobotByRobot(Guide):
    """The zoo goes robot by robot, as many at a time as there are workers: broken off, it has whole robots.

    Terms: end [s]: on the monotonic clock. cases: in their order.
    """

    sitting = 5.0

    def __init__(self, cases: Collection[str], at_once: int, end: float) -> None:
        self._cases, self._at_once, self._end, self.over = [*cases], at_once, end, False

    def end(self) -> float:
        """When its time is up."""
        return self._end

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """Some robots after the others."""
        for first in range(0, len(self._cases), self._at_once):
            mine = set(self._cases[first : first + self._at_once])
            if batch := [trial for trial in trials if trial.case in mine]:
                yield batch

    def broken_off(self, under_way: Sequence[UnderWay]) -> None:
        """The time was up."""
        del under_way
        self.over = True

    def asked(self, trials: Collection[str], records: Mapping[str, Record]) -> Collection[str]:
        """What was answered, where the time was up: --resume goes on with the rest."""
        return [trial for trial in trials if trial in records] if self.over else trials
