"""The journal of a run folder: one checksummed, fsynced line for each finished accuracy or timing run."""

import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Literal

from harness.record import SCHEMA_VERSION, Record, Timing

__all__ = ["FolderTaken", "Journal", "NoRun", "StoreError", "read_journal"]

Kind = Literal["accuracy", "timing"]


class StoreError(Exception):
    """A run folder that cannot be read or written; the message names the path and what to do."""


class NoRun(StoreError):
    """What was asked for is not there: a run folder, a trial or a recording; the message says what there is."""


class FolderTaken(StoreError):
    """The folder that a new run was given holds a run already."""


def _line(kind: Kind, content: dict[str, Any]) -> bytes:
    text = json.dumps({"schema": SCHEMA_VERSION, "kind": kind, "content": content}, sort_keys=True, allow_nan=False)
    return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {text}\n".encode()


def _parse(line: bytes) -> tuple[int, Kind, dict[str, Any]] | None:
    """Schema, kind and content of a line; None where it is torn or corrupt."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or hashlib.sha256(text).hexdigest()[:16].encode() != checksum:
        return None
    parsed = json.loads(text)
    return parsed["schema"], parsed["kind"], parsed["content"]


def _entries(path: Path) -> Iterator[tuple[int, Kind, dict[str, Any]]]:
    """The entries of a journal and, with each, the position in bytes behind it; a torn tail is left out.

    Raises:
        StoreError: for a corrupt line that is not the last, or a schema newer than this program's.
    """
    lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
    position = 0
    for number, line in enumerate(lines, start=1):
        parsed = _parse(line)
        if parsed is None:
            if number == len(lines):
                return
            raise StoreError(f"{path}: line {number} is corrupt (checksum differs); restore it or start a new folder")
        schema, kind, content = parsed
        if schema > SCHEMA_VERSION:
            raise StoreError(
                f"{path}: line {number} has schema {schema}, this program reads up to {SCHEMA_VERSION}; upgrade it"
            )
        position += len(line)
        yield position, kind, content


def read_journal(path: Path) -> dict[str, Record]:
    """All records by trial, each with its timing where there is one. Raises: StoreError."""
    records: dict[str, Record] = {}
    for _, kind, content in _entries(path):
        if kind == "accuracy":
            records[content["trial"]] = Record.from_plain(content)
        else:
            timing = Timing.from_plain(content)
            records[timing.trial] = records[timing.trial].timed(timing)
    return records


class Journal:
    """A journal that is open for writing; the folder is locked against a second writer until it is closed."""

    def __init__(self, folder: Path) -> None:
        """Open or create. A torn last line, as a kill leaves it, is dropped and counted in `dropped`.

        Raises:
            StoreError: where another process writes to this folder, or the journal is corrupt.
        """
        self.path = folder / "journal.jsonl"
        self._file: IO[bytes] = self.path.open("ab")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            self._file.close()
            raise StoreError(f"{folder}: another run writes to this folder; wait for it or choose another --out") from error
        self.records: set[str] = set()
        self.timings: set[str] = set()
        valid = 0
        for position, kind, content in _entries(self.path):
            valid = position
            (self.records if kind == "accuracy" else self.timings).add(content["trial"])
        self.dropped = self.path.stat().st_size - valid
        if self.dropped:
            os.truncate(self.path, valid)

    def append(self, entry: Record | Timing) -> None:
        """Write one entry through to the disk."""
        known = self.records if isinstance(entry, Record) else self.timings
        if entry.trial in known:
            raise StoreError(f"{self.path}: trial {entry.trial} is already there")
        self._file.write(_line("accuracy" if isinstance(entry, Record) else "timing", entry.plain()))
        self._file.flush()
        os.fsync(self._file.fileno())
        known.add(entry.trial)

    def close(self) -> None:
        """Let the folder go; may be called twice."""
        self._file.close()
