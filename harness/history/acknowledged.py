"""Changes that somebody has seen: what is acknowledged is not told again."""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime

from plumbline.harness.history.folder import SCHEMA, History
from plumbline.harness.history.identity import Named
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile

_WHAT = ("kind", "case", "engine", "sense", "since")
"""What a line says of the change beside its id; lines from before there were more say the id alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Acknowledgement:
    """Terms: what: the change. note: what somebody said of it. when: ISO 8601."""

    what: Named
    note: str
    when: str


def acknowledged(history: History) -> dict[str, Acknowledgement]:
    """All that was acknowledged, by id, the last note of each; without lines that cannot be read. Raises: OSError."""
    return read_acknowledged(history)[0]


def read_acknowledged(history: History) -> tuple[dict[str, Acknowledgement], list[DamagedFile]]:
    """The same, with what cannot be read. Raises: OSError."""
    path, damaged = history.acknowledgements, list[DamagedFile]()
    if not path.is_file():
        return {}, [DamagedFile(path, "is no file", "delete it")] if os.path.lexists(path) else []
    known: dict[str, Acknowledgement] = {}
    for number, line in enumerate(disk.read(path).decode("utf-8", errors="replace").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
            what = Named(id=str(row["id"]), **{name: str(row.get(name, "")) for name in _WHAT})
            entry = Acknowledgement(what=what, note=str(row["note"]), when=str(row["when"]))
        except (ValueError, KeyError, TypeError) as error:
            what_is_wrong = f"line {number}: {error!r}, expected id, note and when"
            damaged.append(DamagedFile(path, what_is_wrong, "mend or delete the line"))
            continue
        known[entry.what.id] = entry
    return known, damaged


def silenced(change: Named, known: dict[str, Acknowledgement], stamps: Sequence[str]) -> Acknowledgement | None:
    """Who acknowledged a change, if anybody: by its name, or with an engine as a whole. Args: stamps: of all nights."""
    return next((entry for entry in reversed(known.values()) if entry.what.silences(change, stamps)), None)


def acknowledge(history: History, change: Named, note: str) -> Acknowledgement:
    """Write down that a change was seen. Raises: OSError."""
    entry = Acknowledgement(what=change, note=note, when=datetime.now(UTC).isoformat(timespec="seconds"))
    line = {"schema": SCHEMA, **asdict(change), "note": note, "when": entry.when}
    file = disk.Appended(history.acknowledgements)
    try:
        file.append((json.dumps(line) + "\n").encode())
    finally:
        file.close()
    return entry
