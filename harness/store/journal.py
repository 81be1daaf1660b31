"""The journal of a run folder: one checksummed, fsynced line for each finished accuracy or timing run.

Lines are numbered and each holds the checksum of the one before it, so that one that is missing, doubled or moved is noticed.
Each says when it was written: how long a run took, piece by piece, is read off it, and nothing else.
Beside runs they say under which circumstances a session began, and which trials were withdrawn since they no longer hold.
"""

import fcntl
import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

from plumbline.harness.intake.mendable import LiesIn, Mendable
from plumbline.harness.store import disk
from plumbline.harness.store.record import SCHEMA_VERSION, Record, Timing, parts_of_runs

Kind = Literal["accuracy", "timing", "session", "withdrawn", "restored"]


class StoreError(Mendable):
    """A run folder that cannot be read or written; the message names the path and what to do."""

    lies_in: ClassVar[LiesIn] = "machine"


class DamagedFile(StoreError):
    """A file of a run folder that is not what was written. Terms: path; what is wrong with it; cure: what to do."""

    def __init__(self, path: Path, what: str, cure: str) -> None:
        super().__init__(f"{path}: {what}; {cure}")
        self.path, self.what, self.cure = path, what, cure


class NoRun(StoreError):
    """What was asked for is not there: a run folder, a trial or a recording; the message says what there is."""

    lies_in = "usage"


class NotKept(StoreError):
    """A trajectory of which its hash alone is kept."""


class FolderTaken(StoreError):
    """The folder that a new run was given holds a run already."""

    lies_in = "usage"


@dataclass(slots=True)
class Written:
    """What a journal says.

    Terms:
        records: by trial, each with its timing where there is one, without the withdrawn. clocked: by trial that has a timing,
        the machine of it. withdrawn, lost: by trial that has no record any more, why, and the record that it had.
        sessions: the circumstances of each, in order; made_in: by trial, the number of its session, -1 where none had begun.
        checksums: of all lines.
        end: bytes of whole lines. torn: bytes behind them, what a kill left of a line.
    """

    path: Path
    records: dict[str, Record] = field(default_factory=dict)
    clocked: dict[str, str] = field(default_factory=dict)
    withdrawn: dict[str, str] = field(default_factory=dict)
    lost: dict[str, Record] = field(default_factory=dict)
    sessions: list[Mapping[str, Any]] = field(default_factory=list)
    made_in: dict[str, int] = field(default_factory=dict)
    checksums: list[str] = field(default_factory=list)
    end: int = 0
    torn: int = 0

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the folder has to know of it."""
        if not self.torn:
            return ()
        line = len(self.checksums) + 1
        return (f"{self.path}: line {line}, the last, is torn, as a kill leaves it: {self.torn} bytes are dropped",)

    def take(self, kind: Kind, content: Mapping[str, Any]) -> None:
        """Take in one line. Raises: ValueError, where it cannot follow the others."""
        if kind == "session":
            self.sessions.append(content)
        elif kind == "withdrawn":
            for trial in content["trials"]:
                if trial not in self.records:
                    raise ValueError(f"withdraws trial {trial}, which has no record")
                self.lost[trial], self.withdrawn[trial] = self.records.pop(trial), content["because"]
                self.clocked.pop(trial, None)
        elif kind == "restored":
            for trial in content["trials"]:
                if trial not in self.lost:
                    raise ValueError(f"brings back trial {trial}, which was not withdrawn")
                self._put(self.lost[trial])
        elif kind == "accuracy":
            record = Record.from_plain(content)
            if record.trial in self.records:
                raise ValueError(f"holds trial {record.trial} a second time")
            self.made_in[record.trial] = len(self.sessions) - 1
            self._put(record)
        else:
            timing = Timing.from_plain(content)
            if timing.trial not in self.records:
                raise ValueError(f"clocks trial {timing.trial}, which has no record")
            if self.clocked.get(timing.trial) == timing.clocked_on:
                raise ValueError(f"holds the timing of trial {timing.trial} a second time")
            self.records[timing.trial] = self.records[timing.trial].timed(timing)
            self.clocked[timing.trial] = timing.clocked_on

    def _put(self, record: Record) -> None:
        self.records[record.trial] = record
        self.lost.pop(record.trial, None)
        self.withdrawn.pop(record.trial, None)
        if record.samples:
            self.clocked[record.trial] = record.clocked_on


def _checksum(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:16]


def _line(number: int, before: str, kind: Kind, content: Mapping[str, Any]) -> tuple[str, bytes]:
    """A line and its checksum."""
    at = round(time.time(), 2)
    entry = {"schema": SCHEMA_VERSION, "number": number, "at": at, "before": before, "kind": kind, "content": content}
    text = json.dumps(entry, sort_keys=True, allow_nan=False).encode()
    checksum = _checksum(text)
    return checksum, b"%b %b\n" % (checksum.encode(), text)


def _amiss(written: Written, entry: Mapping[str, Any]) -> str:
    """The error in the chain of the line, or ''."""
    due, before = len(written.checksums) + 1, written.checksums[-1] if written.checksums else ""
    number = entry["number"]
    if number > due:
        missing = f"line {due} is" if number == due + 1 else f"lines {due} to {number - 1} are"
        return f"is numbered {number}: {missing} missing before it"
    if number < due:
        return f"is numbered {number}: it stands twice, or was moved"
    return "" if entry["before"] == before else "does not follow the line before it, which is another than was written"


def check_schema(path: Path, schema: int, where: str = "") -> None:
    """Refuse what a program of another schema wrote. Raises: DamagedFile."""
    if schema > SCHEMA_VERSION:
        raise DamagedFile(path, f"{where}has schema {schema}, this program reads up to {SCHEMA_VERSION}", "upgrade it")
    if schema < SCHEMA_VERSION:
        what = f"{where}has schema {schema}, which no released version wrote; this program reads schema {SCHEMA_VERSION}"
        raise DamagedFile(path, what, "run the study again into a new folder")


def read_written(path: Path) -> Written:
    """All that a journal says; nothing of one that is not there.

    Raises:
        DamagedFile: for a corrupt line, one that is missing, doubled or moved, or another schema than this program's.
    """
    written = Written(path)
    if not path.exists():
        return written
    *lines, rest = disk.read(path).split(b"\n")
    for number, line in enumerate(lines, start=1):
        checksum, _, text = line.partition(b" ")
        last = number == len(lines) and not rest
        if _checksum(text).encode() != checksum:
            if last and b"\0" in line:  # blocks that never reached the disk before the power went
                written.torn = len(line) + 1
                return written
            cure = "restore it, or delete that line and let --resume run its trial anew" if last else "restore it"
            what = f"line {number}{', the last,' if last else ''} is corrupt (its checksum differs)"
            raise DamagedFile(path, what, f"{cure}, or start a new folder")
        entry = json.loads(text)
        check_schema(path, entry["schema"], f"line {number} ")
        amiss = _amiss(written, entry)
        try:
            if amiss:
                raise ValueError(amiss)
            written.take(entry["kind"], entry["content"])
        except ValueError as error:
            raise DamagedFile(path, f"line {number} {error}", "restore the file or start a new folder") from error
        written.checksums.append(checksum.decode())
        written.end += len(line) + 1
    if _checksum(rest[:-1].partition(b" ")[2]).encode() == rest.partition(b" ")[0]:
        raise DamagedFile(path, f"line {len(lines) + 1}, the last, ends in another byte than was written", "restore the file")
    written.torn = len(rest)
    return written


def read_journal(path: Path) -> dict[str, Record]:
    """All records by trial, each with its timing where there is one. Raises: StoreError."""
    return read_written(path).records


class Journal:
    """A journal that is open for writing; the folder is locked against a second writer until it is closed."""

    def __init__(self, folder: Path) -> None:
        """Open or create. A torn last line, as a kill leaves it, is dropped and counted in `dropped`.

        Raises:
            StoreError: where another process writes to this folder, or the journal is corrupt. OSError.
        """
        self.path = folder / "journal.jsonl"
        self._file = disk.Appended(self.path)
        try:
            fcntl.flock(self._file.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.written = read_written(self.path)
            self.dropped, self.notes = self.written.torn, self.written.notes
            self._file.size = self.written.end
            if self.dropped:
                self._file.cut(self.written.end)
                self.written.torn = 0
        except BlockingIOError as error:
            self._file.close()
            raise StoreError(f"{folder}: another run writes to this folder; wait for it or choose another --out") from error
        except BaseException:
            self._file.close()
            raise

    @property
    def records(self) -> Mapping[str, Record]:
        """By trial, each with its timing where there is one."""
        return self.written.records

    @property
    def timings(self) -> Mapping[str, str]:
        """By trial, the machine that it was clocked on."""
        return self.written.clocked

    def begin(self, circumstances: Mapping[str, Any]) -> None:
        """Say what a session begins under, unless that is what the last one began under. Raises: OSError."""
        plain = json.loads(json.dumps(circumstances))
        if not self.written.sessions or self.written.sessions[-1] != plain:
            self._append("session", plain)

    def withdraw(self, trials: Sequence[str], because: str) -> None:
        """Take trials out that no longer hold; their lines stay. Raises: StoreError, OSError."""
        if trials:
            self._append("withdrawn", {"trials": list(trials), "because": because})

    def restore(self, trials: Sequence[str]) -> None:
        """Bring back withdrawn trials that hold again. Raises: OSError."""
        if trials:
            self._append("restored", {"trials": list(trials)})

    def append(self, entry: Record | Timing) -> None:
        """Write one entry through to the disk. Raises: StoreError, where it is there already; OSError."""
        again = self.timings.get(entry.trial) == entry.clocked_on if isinstance(entry, Timing) else entry.trial in self.records
        if again:
            raise StoreError(f"{self.path}: trial {entry.trial} is already there")
        assert not parts_of_runs(entry.clocked, entry.samples), f"trial {entry.trial}: clocked over parts of runs"
        self._append("accuracy" if isinstance(entry, Record) else "timing", entry.plain())

    def _append(self, kind: Kind, content: Mapping[str, Any]) -> None:
        written = self.written
        number, before = len(written.checksums) + 1, written.checksums[-1] if written.checksums else ""
        checksum, line = disk.calls.filled(lambda: _line(number, before, kind, content))
        self._file.append(line)
        written.checksums.append(checksum)
        written.end += len(line)
        written.take(kind, content)

    def close(self) -> None:
        """Let the folder go; may be called twice."""
        self._file.close()
