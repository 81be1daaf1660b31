"""Where a history keeps what: its own file, its nights by their stamps, its pool, the changes that somebody acknowledged; and
its lock: two nights never meet.

The pool: every answer once, under the name of its trial, which covers all that decides it.

A file holds the record of an accuracy run as it was first computed, with the night that computed it. Trajectories lie beside
it by their own hashes, as far as they are kept.
"""

import fcntl
import json
import os
import re
import socket
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import lru_cache
from pathlib import Path
from typing import Any

from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, NoRun, StoreError, check_schema
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.record import SCHEMA_VERSION, Record, from_plain, plain
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import Store, read_plain, write_json

SCHEMA = 1
"""Of every file that a history adds to its run folders; one of a later schema is refused, an earlier one is read."""
NIGHT = "night.json"
"""What a night adds to its run folder: what was planned, left out and recalled; written last, so that a night is whole that has
one which says so."""
_LATEST = timedelta(days=366)
"""A night that is named for a later time than this after now was named by mistake; all nights after it would be, too."""
_DELETE = "restore it, or delete the night"
_STAMP = "%Y%m%dT%H%M%SZ"
_STAMPED = re.compile(r"\d{8}T\d{6}Z")


def stamp_of(moment: datetime) -> str:
    """The name of a night that began then: '20261124T013000Z'."""
    return moment.astimezone(UTC).strftime(_STAMP)


def when(stamp: str) -> datetime:
    """When the night of that name began. Raises: ValueError."""
    return datetime.strptime(stamp, _STAMP).replace(tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class Night:
    """One night. Terms: stamp: its name. folder: its run folder."""

    stamp: str
    folder: Path

    @property
    def began(self) -> datetime:
        """When it began."""
        return when(self.stamp)

    @property
    def plan(self) -> Mapping[str, Any]:
        """What `night.json` says; nothing where it was never written. Raises: DamagedFile, StoreError."""
        path = self.folder / NIGHT
        if not path.is_file():
            return _readable(path)
        status = path.stat()
        return _plan(path, (status.st_size, status.st_mtime_ns, status.st_ino))

    @property
    def whole(self) -> bool:
        """Did it come to its end? Raises: DamagedFile."""
        return bool(self.plan.get("complete"))

    @property
    def machine(self) -> str:
        """The digest of the machine that it ran on; '' where nothing says so."""
        try:
            return machine_digest(self.store().machine)
        except StoreError:
            return ""

    def unread(self) -> DamagedFile | None:
        """Why it cannot be used as a night, but for what its journal holds; None where it can."""
        journal = self.folder / "journal.jsonl"
        try:
            if self.began > datetime.now(UTC) + _LATEST:
                return DamagedFile(self.folder, "is named for a time to come", "rename or delete it")
        except ValueError:
            return DamagedFile(self.folder, "has a name that is no date", "rename or delete it")
        if not journal.is_file():
            return DamagedFile(journal, "is no file", _DELETE)
        try:
            blocks = self.plan.get("blocks", ())
            if not isinstance(blocks, list | tuple):
                return DamagedFile(self.folder / NIGHT, "its blocks are no list", _DELETE)
        except DamagedFile as error:
            return error
        except StoreError as error:
            return DamagedFile(self.folder / NIGHT, str(error), _DELETE)
        return None

    def store(self, only: Collection[tuple[str, str]] | None = None) -> Store:
        """Its tables. Args: only: of these experiments and cases; None for all. Raises: NoRun."""
        return Store(self.folder, only=only)


@dataclass(frozen=True, slots=True)
class History:
    """A history on this machine's disk; one that lies elsewhere is mirrored first (`harness.history.remote_storage`)."""

    root: Path

    @property
    def pool(self) -> Path:
        """The folder of answers."""
        return self.root / "pool"

    def night(self, stamp: str) -> Night:
        """The night of that name, whether it is there or not."""
        return Night(stamp, self.root / "nights" / stamp)

    def each(self) -> Iterator[Night | DamagedFile]:
        """All nights that hold a run, the earliest first, the one that is under way among them; in place of one that cannot be
        read, why, with what there is to do."""
        for path in sorted(path for path in (self.root / "nights").glob("*") if _STAMPED.fullmatch(path.name)):
            if os.path.lexists(path / "journal.jsonl"):
                night = Night(path.name, path)
                yield night.unread() or night

    def nights(self) -> tuple[Night, ...]:
        """Those of `each` that can be read."""
        return tuple(night for night in self.each() if isinstance(night, Night))

    def unread(self) -> tuple[DamagedFile, ...]:
        """What is left out of `nights`."""
        return tuple(error for error in self.each() if isinstance(error, DamagedFile))

    def whole_nights(self) -> tuple[Night, ...]:
        """The nights that came to their end, the earliest first. Raises: DamagedFile."""
        return tuple(night for night in self.nights() if night.whole)


@lru_cache(maxsize=256)
def _plan(path: Path, _status: tuple[int, int, int]) -> Mapping[str, Any]:
    """Read once as long as it is the same file."""
    return _readable(path)


def _readable(path: Path) -> dict[str, Any]:
    if os.path.lexists(path) and not path.is_file():
        raise DamagedFile(path, "is no file", "restore it")
    kept = read_plain(path)
    if kept.get("schema", SCHEMA) > SCHEMA:
        raise DamagedFile(path, f"has schema {kept['schema']}, this program reads up to {SCHEMA}", "upgrade it")
    return kept


def opened(root: Path) -> History:
    """The history in a folder. Raises: NoRun, where there is none; StoreError, where it is of a later schema."""
    if not (root / "history.json").is_file():
        raise NoRun(f"{root}: no history (no history.json); plumbline nightly --history {root} begins one")
    _readable(root / "history.json")
    return History(root)


def created(root: Path) -> History:
    """The history in a folder, begun where there is none. Raises: StoreError, where it holds something else; OSError."""
    if not (root / "history.json").is_file():
        if root.is_dir() and any(path.name != "lock" for path in root.iterdir()):
            raise StoreError(f"{root}: holds something else than a history; choose another --history")
        disk.make_folder(root)
        write_json(root / "history.json", {"schema": SCHEMA, "begun": datetime.now(UTC).isoformat(timespec="seconds")})
    return opened(root)


def holder() -> dict[str, Any]:
    """Who this process is, for others to read."""
    moment = datetime.now(UTC).isoformat(timespec="seconds")
    return {"schema": SCHEMA, "host": socket.gethostname(), "process": os.getpid(), "since": moment}


@contextmanager
def locked(history: History) -> Iterator[None]:
    """Hold a history; the file says who does, the system lets it go when the process ends.

    Raises: StoreError, where another process holds it. OSError.
    """
    path = history.root / "lock"
    if os.path.lexists(path) and not path.is_file():
        raise StoreError(f"{path}: is no file; delete it")
    descriptor = disk.calls.open(path, os.O_RDWR | os.O_CREAT)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            content = os.pread(descriptor, 1000, 0).decode(errors="replace")
            raise StoreError(f"{history.root}: another night holds it ({_words(content)}); wait for its end") from error
        disk.calls.truncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(holder()).encode(), 0)
        yield
        disk.calls.truncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _words(content: str) -> str:
    try:
        known = json.loads(content)
        return f"process {known['process']} on {known['host']} since {known['since']}"
    except (ValueError, KeyError, TypeError):
        return "it does not say who"


MACHINE_BOUND = ("timeout", "oom", "crashed")
"""Outcomes that a faster or a larger machine may not have: they are recalled on the machine that had them only."""
POOLED = ("passed", "failed", "diverged", "unsupported", *MACHINE_BOUND)
"""Outcomes that are kept; what is not installed, or was interrupted, is asked again."""


@dataclass(frozen=True, slots=True)
class Pool:
    """The answers in a folder."""

    folder: Path

    def path_of(self, trial: str) -> Path:
        """Where the answer of a trial lies, or would."""
        return self.folder / trial[:2] / f"{trial}.json"

    def trajectory_path(self, trajectory_hash: str) -> Path:
        """Where a trajectory lies, where it is kept."""
        return self.folder / "trajectories" / trajectory_hash[:2] / f"{trajectory_hash}.npz"

    def holds(self, trial: str) -> bool:
        """Is there an answer to a trial of this name?"""
        return self.path_of(trial).is_file()

    def answer(self, trial: str) -> Record | None:
        """What is known of a trial of this name, as recalled from the night that computed it, without a timing; None where
        nothing is. Raises: DamagedFile, OSError."""
        path = self.path_of(trial)
        if not path.is_file():
            return None
        kept = read_plain(path)
        try:
            if kept["schema"] > SCHEMA:
                raise DamagedFile(path, f"has schema {kept['schema']}, this program reads up to {SCHEMA}", "upgrade it")
            check_schema(path, kept["record_schema"])
            return replace(from_plain(Record, kept["record"]), recalled=str(kept["night"]))
        except (KeyError, TypeError, ValueError) as error:
            raise DamagedFile(path, f"is no answer of this schema: {error!r}", "delete it") from error

    def keep(self, record: Record, night: str) -> None:
        """Keep an answer, in place of one of its name. Raises: DamagedFile, where something else lies there; OSError."""
        if record.status not in POOLED:
            return
        if os.path.lexists(self.path_of(record.trial)) and not self.path_of(record.trial).is_file():
            raise DamagedFile(self.path_of(record.trial), "is no file", "delete it")
        kept = plain(replace(record, recalled="", again=""))
        content: dict[str, Any] = {"schema": SCHEMA, "record_schema": SCHEMA_VERSION, "night": night, "record": kept}
        path = self.path_of(record.trial)
        disk.make_folder(path.parent)
        disk.write_atomically(path, sealed_json(path.name, content))

    def keep_trajectory(self, path: Path) -> None:
        """Keep a trajectory of a run folder: one file under two names where the disk allows, also where it is kept already.
        Raises: OSError."""
        kept = self.trajectory_path(path.stem)
        if not kept.is_file():
            disk.make_folder(kept.parent)
            _lay(path, kept)
        elif not kept.samefile(path):
            _lay(kept, path)

    def lay(self, path: Path) -> bool:
        """Lay the trajectory that a path is named after there: is it kept? Raises: OSError."""
        kept = self.trajectory_path(path.stem)
        if not kept.is_file():
            return False
        disk.make_folder(path.parent)
        _lay(kept, path)
        return True

    def answers(self) -> Iterator[Path]:
        """The files of all answers."""
        yield from sorted(self.folder.glob("[0-9a-f][0-9a-f]/*.json"))

    def trajectories(self) -> Iterator[Path]:
        """The files of all trajectories."""
        yield from sorted(self.folder.glob("trajectories/[0-9a-f][0-9a-f]/*.npz"))


def _lay(path: Path, other: Path) -> None:
    """Give a file a second name, in place of what has it; a copy where the disk knows no two names."""
    draft = other.with_name(f".{other.name}.{os.getpid()}") if other.exists() else other
    try:
        os.link(path, draft)
    except OSError:
        disk.write_atomically(other, disk.read(path))
    else:
        if draft != other:
            disk.put_in_place(draft, other)
