"""The pool: every answer once, under the name of its trial, which covers all that decides it.

A file holds the record of an accuracy run as it was first computed, with the night that computed it. Trajectories lie beside
it by their own hashes, as far as they are kept.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plumbline.harness.history.folder import SCHEMA
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, check_schema
from plumbline.harness.store.record import SCHEMA_VERSION, Record, from_plain, plain
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import read_plain

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
