"""Changes that somebody has seen: what is acknowledged is not told again."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from datetime import UTC, datetime

from plumbline.harness.history.folder import SCHEMA, History
from plumbline.harness.history.identity import Named
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile


def acknowledged(history: History) -> dict[str, Named]:
    """All that was acknowledged, by id, the last note of each; without lines that cannot be read. Raises: OSError."""
    return read_acknowledged(history)[0]


def read_acknowledged(history: History) -> tuple[dict[str, Named], list[DamagedFile]]:
    """The same, with what cannot be read. Raises: OSError."""
    path, damaged = history.acknowledgements, list[DamagedFile]()
    if not path.is_file():
        return {}, [DamagedFile(path, "is no file", "delete it")] if os.path.lexists(path) else []
    known: dict[str, Named] = {}
    for number, line in enumerate(disk.read(path).decode("utf-8", errors="replace").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
            said = {name: row[name] for name in ("id", "note", "when")}  # lines of an older version say nothing else
            entry = Named(**{each.name: str((row | said).get(each.name, "")) for each in fields(Named)})
        except (ValueError, KeyError, TypeError) as error:
            what_is_wrong = f"line {number}: {error!r}, expected id, note and when"
            damaged.append(DamagedFile(path, what_is_wrong, "mend or delete the line"))
            continue
        known[entry.id] = entry
    return known, damaged


def silenced(change: Named, known: Mapping[str, Named], stamps: Sequence[str]) -> Named | None:
    """Who acknowledged a change, if anybody: by its name, or with an engine as a whole. Args: stamps: of all nights."""
    return next((entry for entry in reversed([*known.values()]) if entry.silences(change, stamps)), None)


def acknowledge(history: History, change: Named, note: str) -> None:
    """Write down that a change was seen. Raises: OSError."""
    entry = replace(change, note=note, when=datetime.now(UTC).isoformat(timespec="seconds"))
    file = disk.Appended(history.acknowledgements)
    try:
        file.append((json.dumps({"schema": SCHEMA, **asdict(entry)}) + "\n").encode())
    finally:
        file.close()
