"""Where a history keeps what: its own file, its nights by their stamps, its pool, the changes that somebody acknowledged."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, NoRun, StoreError
from plumbline.harness.store.store import Store, read_plain, write_json

SCHEMA = 1
"""Of every file that a history adds to its run folders; one of a later schema is refused, an earlier one is read."""
NIGHT = "night.json"
"""What a night adds to its run folder: what was planned, left out and recalled; written last, so that a night is whole that has
one which says so."""
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
        return _readable(self.folder / NIGHT)

    @property
    def whole(self) -> bool:
        """Did it come to its end? Raises: DamagedFile."""
        return bool(self.plan.get("complete"))

    def store(self) -> Store:
        """Its tables. Raises: NoRun."""
        return Store(self.folder)

    def store_of(self, blocks: Collection[tuple[str, str]]) -> Store:
        """The tables of these experiments and cases alone. Raises: NoRun."""
        return Store(self.folder, only=blocks)


@dataclass(frozen=True, slots=True)
class History:
    """A history on this machine's disk; one that lies elsewhere is mirrored first (`harness.history.remote_storage`)."""

    root: Path

    @property
    def pool(self) -> Path:
        """The folder of answers."""
        return self.root / "pool"

    @property
    def lock(self) -> Path:
        """The file that a night holds while it runs."""
        return self.root / "lock"

    @property
    def acknowledgements(self) -> Path:
        """The changes that somebody has seen, one a line."""
        return self.root / "acknowledged.jsonl"

    def night(self, stamp: str) -> Night:
        """The night of that name, whether it is there or not."""
        return Night(stamp, self.root / "nights" / stamp)

    def nights(self) -> tuple[Night, ...]:
        """All nights that hold a run, the earliest first, the one that is under way among them."""
        folders = sorted(path for path in (self.root / "nights").glob("*") if _STAMPED.fullmatch(path.name))
        return tuple(Night(path.name, path) for path in folders if (path / "journal.jsonl").is_file())

    def whole_nights(self) -> tuple[Night, ...]:
        """The nights that came to their end, the earliest first. Raises: DamagedFile."""
        return tuple(night for night in self.nights() if night.whole)


def _readable(path: Path) -> dict[str, Any]:
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
