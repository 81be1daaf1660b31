"""The stable id of a change, in every night's report and where it is acknowledged, and who acknowledged it."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from typing import Any

from plumbline.harness.findings.changes import Change
from plumbline.harness.history.folder import SCHEMA, History
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile
from plumbline.harness.store.record import digest

SEEN = "acknowledged.jsonl"
"""Of a history: the changes that somebody has seen, one a line."""
NEAR = 3
"""Nights by which the night of a step in a price may still move as more nights come."""
_ABOUT = ("kind", "case", "engine", "sense")


def change_id(change: Change, first_seen: str) -> str:
    """The stable id of a change, from its first night on. Args: first_seen: the stamp of that night.

    That of a price is one of a case on an engine, or of the engine as a whole: its tracks and time steps move together, and a
    night tells some of them before it is known whether all of them did.
    """
    setting = ("", "") if change.kind == "price" else (change.track, change.metric)
    return digest([change.kind, change.case, change.engine, *setting, first_seen])


@dataclass(frozen=True, slots=True, kw_only=True)
class Named:
    """A change that has its name already.

    Terms: id: as `change_id` gives it. kind, case, engine, sense: of the change. since: the stamp of the night that it has
    been called by. note, when: of who acknowledged it, what was said of it and when, ISO 8601; '' for nobody.
    """

    id: str
    kind: str = ""
    case: str = ""
    engine: str = ""
    sense: str = ""
    since: str = ""
    note: str = ""
    when: str = ""

    @classmethod
    def of(cls, change: Change, since: str) -> "Named":
        """A change by its first night."""
        return cls(id=change_id(change, since), since=since, **{name: getattr(change, name) for name in _ABOUT})

    @classmethod
    def told(cls, row: Mapping[str, Any]) -> "Named":
        """As `night.json` keeps it."""
        return cls(id=row["id"], since=row["first_seen"], **{name: row[name] for name in _ABOUT})

    def contains(self, other: "Named | Change") -> bool:
        """Is it of the same prices the same way, or of an engine as a whole, whose cases went with it? The night apart."""
        same = (self.kind, self.engine, self.sense) == (other.kind, other.engine, other.sense)
        return self.kind == "price" and same and self.case in ("", other.case)

    def silences(self, other: "Named", stamps: Sequence[str]) -> bool:
        """Is the other one acknowledged with this one? Args: stamps: of all nights, the earliest first."""
        if self.id == other.id:
            return True
        known = self.since in stamps and other.since in stamps
        return known and self.contains(other) and abs(stamps.index(self.since) - stamps.index(other.since)) <= NEAR


def acknowledged(history: History) -> tuple[dict[str, Named], list[DamagedFile]]:
    """All that was acknowledged, by id, the last note of each; and what of it cannot be read. Raises: OSError."""
    path, damaged = history.root / SEEN, list[DamagedFile]()
    if not path.is_file():
        return {}, [DamagedFile(path, "is no file", "delete it")] if os.path.lexists(path) else []
    known: dict[str, Named] = {}
    for number, line in enumerate(disk.read(path).decode("utf-8", errors="replace").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
            always = {name: row[name] for name in ("id", "note", "when")}  # lines of an older version say nothing else
            known[str(row["id"])] = Named(**{each.name: str((row | always).get(each.name, "")) for each in fields(Named)})
        except (ValueError, KeyError, TypeError) as error:
            what_is_wrong = f"line {number}: {error!r}, expected id, note and when"
            damaged.append(DamagedFile(path, what_is_wrong, "mend or delete the line"))
    return known, damaged


def silenced(change: Named, known: Mapping[str, Named], stamps: Sequence[str]) -> Named | None:
    """Who acknowledged a change, if anybody: by its name, or with an engine as a whole. Args: stamps: of all nights."""
    return next((entry for entry in reversed([*known.values()]) if entry.silences(change, stamps)), None)


def acknowledge(history: History, change: Named, note: str) -> None:
    """Write down that a change was seen. Raises: OSError."""
    entry = replace(change, note=note, when=datetime.now(UTC).isoformat(timespec="seconds"))
    file = disk.Appended(history.root / SEEN)
    try:
        file.append((json.dumps({"schema": SCHEMA, **asdict(entry)}) + "\n").encode())
    finally:
        file.close()
