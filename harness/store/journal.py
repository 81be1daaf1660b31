"""The journal of a run folder: one checksummed, fsynced line for each finished accuracy or timing run.

Lines are numbered and each holds the checksum of the one before it, so that one that is missing, doubled or moved is noticed.
Each says when it was written: how long a run took, piece by piece, is read off it, and nothing else.
Beside runs they say under which circumstances a session began, and which trials were withdrawn since they no longer hold.
"""

import fcntl
import hashlib
import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from plumbline.harness.intake.error import LiesIn, PlumblineError
from plumbline.harness.store import disk
from plumbline.harness.store.forms import CONTENTS, JournalLine, Kind
from plumbline.harness.store.record import SCHEMA_VERSION, Record, Timing, checked, from_plain, parts_of_runs, plain


class StoreError(PlumblineError):
    """A run folder that cannot be read or written; the message names the path and what to do."""

    lies_in: ClassVar[LiesIn] = "machine"


class DamagedFile(StoreError):
    """A file of a run folder that is not what was written. Terms: path; what is wrong with it; cure: what to do."""

    def __init__(self, path: Path, what: str, cure: str) -> None:
        super().__init__(f"{path}: {what}; {cure}")
        self.path, self.what, self.cure = path, what, cure


def refuse_links(folder: Path) -> None:
    """A run writes to no place, and takes nothing away there, that somebody else has put behind a name. Raises: StoreError."""
    for name in ("journal.jsonl", "trajectories", "truths", "recordings", "scenes", "logs"):
        if (folder / name).is_symlink():
            raise StoreError(f"{folder / name}: is a link, expected what it names in its place; nothing was written")


class NoRun(StoreError):
    """What was asked for is not there: a run folder, a trial or a recording; the message says what there is."""

    lies_in = "usage"


class NotKept(StoreError):
    """A trajectory of which its hash alone is kept."""


class FolderTaken(StoreError):
    """The folder that a new run was given holds a run already."""

    lies_in = "usage"


Entry = TypeVar("Entry")


@dataclass
class LineChain(Generic[Entry]):
    """The lines of a journal so far, whatever is kept of a record.

    Terms:
        entries: by trial, what is kept of its record, without the withdrawn; lost: the same of the withdrawn. withdrawn: by
        trial, why. made_in: by trial, the number of its session, -1 where none had begun.
        sessions: the circumstances of each, in order. checksums: of all lines.
        end: bytes of whole lines; content: the digest of them, under way. torn: bytes behind them, what a kill left of a line.
    """

    path: Path
    entries: dict[str, Entry] = field(default_factory=dict)
    lost: dict[str, Entry] = field(default_factory=dict)
    withdrawn: dict[str, str] = field(default_factory=dict)
    made_in: dict[str, int] = field(default_factory=dict)
    sessions: list[Mapping[str, Any]] = field(default_factory=list)
    checksums: list[str] = field(default_factory=list)
    end: int = 0
    content: "hashlib._Hash" = field(default_factory=hashlib.sha256)
    torn: int = 0

    @property
    def reached(self) -> dict[str, Any]:
        """How far it has come, for the folder's machine.json: so lines that go missing at its end are noticed."""
        last = self.checksums[-1] if self.checksums else ""
        return {"lines": len(self.checksums), "checksum": last, "content": self.content.hexdigest()}

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the folder has to know of it."""
        if not self.torn:
            return ()
        line = len(self.checksums) + 1
        return (f"{self.path}: line {line}, the last, is torn, as a kill leaves it: {self.torn} bytes are dropped",)

    def follow(self, checksum: str, line: bytes) -> None:
        """Count a whole line in."""
        self.checksums.append(checksum)
        self.end += len(line)
        self.content.update(line)

    def take(self, kind: Kind, content: Mapping[str, Any]) -> None:
        """Take in what one line says, which begins at `end`. Raises: ValueError, where it cannot follow the others."""
        trials: Sequence[str] = content.get("trials", ())
        if kind == "session":
            self.sessions.append(content)
        elif kind == "withdrawn":
            for trial in trials:
                if trial not in self.entries:
                    raise ValueError(f"withdraws trial {trial}, which has no record")
                self.lost[trial] = self.entries.pop(trial)
                self.withdrawn[trial] = content.get("because", "")
        elif kind == "restored":
            for trial in trials:
                if trial not in self.withdrawn:
                    raise ValueError(f"brings back trial {trial}, which was not withdrawn")
                self.entries[trial] = self.lost.pop(trial)
                del self.withdrawn[trial]
        elif not isinstance(name := content.get("trial"), str):
            raise ValueError(f"holds no {kind} of a trial: got {str(name)[:80]!r} for its name")
        elif kind == "accuracy":
            if name in self.entries:
                raise ValueError(f"holds trial {name} a second time")
            name = sys.intern(name)  # which other folders have too
            self.entries[name] = self.answered(from_plain(Record, content))
            self.made_in[name] = len(self.sessions) - 1
            self.lost.pop(name, None)
            self.withdrawn.pop(name, None)
        else:
            if name not in self.entries:
                raise ValueError(f"clocks trial {name}, which has no record")
            timing = from_plain(Timing, content)
            if self.clocked_on(name) == timing.clocked_on:
                raise ValueError(f"holds the timing of trial {name} a second time")
            self.entries[name] = self.timed(self.entries[name], timing)

    def clocked_on(self, trial: str) -> str | None:
        """The machine of its timing; None without one."""
        raise NotImplementedError

    def answered(self, record: Record) -> Entry:
        """What is kept of a record."""
        raise NotImplementedError

    def timed(self, entry: Entry, timing: Timing) -> Entry:
        """What is kept of the same record with its timing."""
        raise NotImplementedError


class Written(LineChain[Record]):
    """All that a journal says: its entries are records, each with its timing where there is one."""

    @property
    def records(self) -> dict[str, Record]:
        """By trial, without the withdrawn."""
        return self.entries

    def clocked_on(self, trial: str) -> str | None:
        """The machine of its timing; None without one."""
        timing = self.entries[trial].timing if trial in self.entries else None
        return None if timing is None else timing.clocked_on

    def answered(self, record: Record) -> Record:
        """All of it."""
        return record

    def timed(self, entry: Record, timing: Timing) -> Record:
        """The record with its timing."""
        return replace(entry, timing=timing)


def _checksum(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:16]


def _line(number: int, before: str, kind: Kind, content: Mapping[str, Any]) -> tuple[str, bytes]:
    """A line and its checksum."""
    at = round(time.time(), 2)
    entry = {"schema": SCHEMA_VERSION, "number": number, "at": at, "before": before, "kind": kind, "content": content}
    text = json.dumps(entry, sort_keys=True, allow_nan=False).encode()
    checksum = _checksum(text)
    return checksum, b"%b %b\n" % (checksum.encode(), text)


def _amiss(written: LineChain[Any], entry: JournalLine) -> str:
    """The error in the chain of the line, or ''."""
    due, before = len(written.checksums) + 1, written.checksums[-1] if written.checksums else ""
    number = entry.number
    if number > due:
        missing = f"line {due} is" if number == due + 1 else f"lines {due} to {number - 1} are"
        return f"is numbered {number}: {missing} missing before it"
    if number < due:
        return f"is numbered {number}: it stands twice, or was moved"
    return "" if entry.before == before else "does not follow the line before it, which is another than was written"


def check_schema(path: Path, schema: int, where: str = "") -> None:
    """Refuse what a program of another schema wrote. Raises: DamagedFile."""
    if schema > SCHEMA_VERSION:
        raise DamagedFile(path, f"{where}has schema {schema}, this program reads up to {SCHEMA_VERSION}", "upgrade it")
    if schema < SCHEMA_VERSION:
        what = f"{where}has schema {schema}, which no released version wrote; this program reads schema {SCHEMA_VERSION}"
        raise DamagedFile(path, what, "run the study again into a new folder")


Lines = TypeVar("Lines", bound=LineChain[Any])


def read_lines(chain: Lines) -> Lines:
    """Take all lines of the journal at `chain.path` in, one after the other; nothing of one that is not there.

    Raises:
        DamagedFile: for no regular file, a corrupt line, one that is missing, doubled or moved, or another schema than this
        program's.
    """
    if not chain.path.exists():
        return chain
    if not chain.path.is_file():  # of a pipe, nothing might ever come
        raise DamagedFile(chain.path, "is no regular file", "take it away, or restore it")
    with disk.calls.reader(chain.path) as file:
        number, line = 1, file.readline()
        while line:
            following = file.readline()
            if not _take(chain, number, line, last=not following):
                break
            number, line = number + 1, following
    return chain


def _take(chain: LineChain[Any], number: int, line: bytes, *, last: bool) -> bool:
    """Take one line in; False for the rest that a kill left of one. Raises: DamagedFile."""
    path = chain.path
    checksum, _, text = line.removesuffix(b"\n").partition(b" ")
    if not line.endswith(b"\n"):
        if _checksum(text[:-1]).encode() == checksum:
            raise DamagedFile(path, f"line {number}, the last, ends in another byte than was written", "restore the file")
        chain.torn = len(line)
        return False
    if _checksum(text).encode() != checksum:
        if last and b"\0" in line:  # blocks that never reached the disk before the power went
            chain.torn = len(line)
            return False
        cure = "restore it, or delete that line and let --resume run its trial anew" if last else "restore it"
        what = f"line {number}{', the last,' if last else ''} is corrupt (its checksum differs)"
        raise DamagedFile(path, what, f"{cure}, or start a new folder")
    try:
        mapping = json.loads(text)
        if isinstance(mapping, dict) and isinstance(mapping.get("schema"), int):
            check_schema(path, mapping["schema"], f"line {number} ")
        entry = checked(JournalLine, mapping, "line")
        if amiss := _amiss(chain, entry):
            raise ValueError(amiss)
        if entry.kind in CONTENTS:
            checked(CONTENTS[entry.kind], entry.content, entry.kind)
        chain.take(entry.kind, entry.content)
    except (ValueError, RecursionError) as error:
        raise DamagedFile(path, f"line {number} {error}", "restore the file or start a new folder") from error
    chain.follow(checksum.decode(), line)
    return True


def read_written(path: Path) -> Written:
    """All that a journal says; nothing of one that is not there. Raises: DamagedFile, as `read_lines` does."""
    return read_lines(Written(path))


def read_journal(path: Path) -> dict[str, Record]:
    """All records by trial, each with its timing where there is one. Raises: StoreError."""
    return read_written(path).records


class Writer(Generic[Lines]):
    """A journal that is open for writing; the folder is locked against a second writer until it is closed."""

    def __init__(self, chain: Lines, *, waits: bool = True) -> None:
        """Open or create. A torn last line, as a kill leaves it, is dropped and counted in `dropped`.

        waits: each line is on the disk before the next is written; else all are once the journal is closed.
        Raises:
            StoreError: where another process writes to this folder, or the journal is corrupt. OSError.
        """
        self.path = chain.path
        self._file = disk.Appended(self.path, waits=waits)
        try:
            fcntl.flock(self._file.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.written = read_lines(chain)
            self.dropped, self.notes = self.written.torn, self.written.notes
            self._file.size = self.written.end
            if self.dropped:
                self._file.cut(self.written.end)
                self.written.torn = 0
        except BlockingIOError as error:
            self._file.close()
            where = self.path.parent
            raise StoreError(f"{where}: another run writes to this folder; wait for it or choose another --out") from error
        except BaseException:
            self._file.close()
            raise

    def begin(self, circumstances: Mapping[str, Any]) -> None:
        """Say what a session begins under, unless that is what the last one began under. Raises: OSError."""
        session = json.loads(json.dumps(circumstances))
        if not self.written.sessions or self.written.sessions[-1] != session:
            self._append("session", session)

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
        held, timing = entry.trial in self.written.entries, entry if isinstance(entry, Timing) else entry.timing
        if (held and self.written.clocked_on(entry.trial) == entry.clocked_on) if isinstance(entry, Timing) else held:
            raise StoreError(f"{self.path}: trial {entry.trial} is already there")
        assert timing is None or not parts_of_runs(timing), f"trial {entry.trial}: clocked over parts of runs"
        self._append("accuracy" if isinstance(entry, Record) else "timing", plain(entry))

    def _append(self, kind: Kind, content: Mapping[str, Any]) -> None:
        written = self.written
        number, before = len(written.checksums) + 1, written.checksums[-1] if written.checksums else ""
        checksum, line = disk.calls.filled(lambda: _line(number, before, kind, content))
        self._file.append(line)
        written.take(kind, content)
        written.follow(checksum, line)

    def close(self) -> None:
        """Let the folder go; may be called twice."""
        self._file.close()


class Journal(Writer[Written]):
    """That of a run, with all that it says."""

    def __init__(self, folder: Path) -> None:
        """Open or create, as a `Writer` does."""
        super().__init__(Written(folder / "journal.jsonl"))

    @property
    def records(self) -> Mapping[str, Record]:
        """By trial, each with its timing where there is one."""
        return self.written.records
