"""Changes that somebody has seen: what is acknowledged is not told again."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime

from harness.findings.changes import Change
from harness.history.folder import SCHEMA, History
from harness.store import disk
from harness.store.journal import DamagedFile
from harness.store.record import digest

__all__ = ["Acknowledgement", "acknowledge", "acknowledged", "change_id"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Acknowledgement:
    """Terms: id: of the change, as `change_id` gives it. note: what somebody said of it. when: ISO 8601."""

    id: str
    note: str
    when: str


def change_id(change: Change, first_seen: str) -> str:
    """What a change is called from its first night on. Args: first_seen: the stamp of that night."""
    return digest([change.kind, change.case, change.engine, change.track, change.metric, first_seen])


def acknowledged(history: History) -> Mapping[str, Acknowledgement]:
    """All that was acknowledged, by id, the last note of each. Raises: DamagedFile, OSError."""
    path = history.acknowledgements
    if not path.is_file():
        return {}
    known: dict[str, Acknowledgement] = {}
    for number, line in enumerate(disk.read(path).decode("utf-8", errors="replace").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
            entry = Acknowledgement(id=str(row["id"]), note=str(row["note"]), when=str(row["when"]))
        except (ValueError, KeyError, TypeError) as error:
            cure = "mend or delete the line"
            raise DamagedFile(path, f"line {number}: {error!r}, expected id, note and when", cure) from error
        known[entry.id] = entry
    return known


def acknowledge(history: History, change: str, note: str) -> Acknowledgement:
    """Write down that a change was seen. Args: change: its id. Raises: OSError."""
    entry = Acknowledgement(id=change, note=note, when=datetime.now(UTC).isoformat(timespec="seconds"))
    file = disk.Appended(history.acknowledgements)
    try:
        file.append((json.dumps({"schema": SCHEMA, **asdict(entry)}) + "\n").encode())
    finally:
        file.close()
    return entry
