"""Where the records of a journal stand in it: for those who read large ones record by record, and not all at once."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plumbline.harness.store import disk
from plumbline.harness.store.journal import LineChain, read_lines
from plumbline.harness.store.record import Record, Timing
from plumbline.harness.store.stored_tables import ORDER, Order, order_of


@dataclass(slots=True)
class Whereabouts:
    """Where a record and its timing stand [bytes], and what is asked of many at once.

    Terms: order: among the rows of tables. timing: None without a line of its own. question: what is clocked side by side, a
    case at its parameters, whatever the engine. machine: that of the timing, None without one; clocked: what it is of.
    """

    order: Order
    start: int
    status: str
    trajectory_hash: str | None
    trajectory_kept: bool
    question: str
    machine: str | None
    clocked: str
    timing: int | None = None

    @property
    def answer(self) -> str:
        """The hash of what the engine said, or the status of a trial without an answer."""
        return self.trajectory_hash or self.status


@dataclass(slots=True)
class Index(LineChain):
    """Terms: entries: by trial, without the withdrawn; lost: those of the withdrawn."""

    entries: dict[str, Whereabouts] = field(default_factory=dict)
    lost: dict[str, Whereabouts] = field(default_factory=dict)

    def holds(self, trial: str) -> bool:
        """Has it a record of this trial?"""
        return trial in self.entries

    def clocked_on(self, trial: str) -> str | None:
        """The machine of its timing; None without one."""
        return self.entries[trial].machine

    def answer(self, content: Mapping[str, Any]) -> None:
        """A record in plain values. Raises: ValueError."""
        record = Record.from_plain(content)
        self.entries[record.trial] = Whereabouts(
            order=order_of({name: getattr(record, name) for name in ORDER}),
            start=self.end,
            status=record.status,
            trajectory_hash=record.trajectory_hash,
            trajectory_kept=record.trajectory_kept,
            question=repr((record.experiment, record.case, sorted(record.parameters.items(), key=str))),
            machine=record.clocked_on if record.samples else None,
            clocked=record.clocked,
        )

    def time(self, content: Mapping[str, Any]) -> None:
        """A timing in plain values. Raises: ValueError."""
        timing, entry = Timing.from_plain(content), self.entries[content["trial"]]
        entry.timing, entry.machine, entry.clocked = self.end, timing.clocked_on, timing.clocked

    def withdraw(self, trial: str) -> None:
        """Take a record out."""
        self.lost[trial] = self.entries.pop(trial)

    def restore(self, trial: str) -> None:
        """Bring a withdrawn record back."""
        self.entries[trial] = self.lost.pop(trial)

    def records(self) -> Iterator[Record]:
        """One after the other, as rows of tables stand, each with its timing. Raises: OSError."""
        with disk.calls.reader(self.path) as file:

            def content(start: int) -> Mapping[str, Any]:
                file.seek(start)
                plain: Mapping[str, Any] = json.loads(file.readline().partition(b" ")[2])["content"]
                return plain

            for entry in sorted(self.entries.values(), key=lambda entry: entry.order):
                record = Record.from_plain(content(entry.start))
                yield record if entry.timing is None else record.timed(Timing.from_plain(content(entry.timing)))


def read_index(path: Path) -> Index:
    """Of a journal; nothing of one that is not there. Raises: DamagedFile, as `read_lines` does."""
    return read_lines(Index(path))
