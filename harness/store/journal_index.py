"""Where the records of a journal stand in it: for those who read large ones record by record, and not all at once."""

import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plumbline.harness.store import disk
from plumbline.harness.store.journal import LineChain, read_lines
from plumbline.harness.store.record import Record, Timing, from_plain
from plumbline.harness.store.stored_tables import Order, order_of


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """Where a record and its timing stand [bytes], and what is asked of many at once.

    Terms: order: among the rows of tables. timing: None without a line of its own. question: what is clocked side by side, a
    case at its parameters, whatever the engine. machine: that of the timing, None without one.
    """

    order: Order
    start: int
    status: str
    trajectory_hash: str | None
    trajectory_kept: bool
    question: str
    machine: str | None
    timing: int | None = None

    @property
    def answer(self) -> str:
        """The hash of what the engine said, or the status of a trial without an answer."""
        return self.trajectory_hash or self.status


def _once(value: Any) -> Any:
    """The value; a text as the equal one that is in memory already, as records and folders share most of theirs."""
    return sys.intern(value) if isinstance(value, str) else value


class Index(LineChain[Whereabouts]):
    """Its entries say where records stand."""

    def clocked_on(self, trial: str) -> str | None:
        """The machine of its timing; None without one."""
        return self.entries[trial].machine if trial in self.entries else None

    def answered(self, record: Record) -> Whereabouts:
        """Where it stands: at the end of what was read."""
        order: Any = tuple(map(_once, order_of(record)))
        return Whereabouts(
            order=order,
            start=self.end,
            status=_once(record.status),
            trajectory_hash=_once(record.trajectory_hash),
            trajectory_kept=record.trajectory_kept,
            question=_once(repr((record.experiment, record.case, sorted(record.parameters.items(), key=str)))),
            machine=None if record.timing is None else _once(record.timing.clocked_on),
        )

    def timed(self, entry: Whereabouts, timing: Timing) -> Whereabouts:
        """Its timing stands at the end of what was read."""
        return replace(entry, timing=self.end, machine=timing.clocked_on)

    def records(self) -> Iterator[Record]:
        """One after the other, as rows of tables stand, each with its timing. Raises: OSError."""
        with disk.calls.reader(self.path) as file:

            def content(start: int) -> Mapping[str, Any]:
                file.seek(start)
                mapping: Mapping[str, Any] = json.loads(file.readline().partition(b" ")[2])["content"]
                return mapping

            for entry in sorted(self.entries.values(), key=lambda entry: entry.order):
                record = from_plain(Record, content(entry.start))
                yield record if entry.timing is None else replace(record, timing=from_plain(Timing, content(entry.timing)))


def read_index(path: Path) -> Index:
    """Of a journal; nothing of one that is not there. Raises: DamagedFile, as `read_lines` does."""
    return read_lines(Index(path))
