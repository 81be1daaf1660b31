"""Where a history lies: a folder of this machine, or any address that fsspec reaches, of which a copy is kept here.

A night runs in the copy and is sent when it is whole: answers first, its own file last, so that whoever fetches meanwhile sees
whole nights only. Trajectories travel once, with the pool; a night's own are laid out again from there.
"""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path, PurePosixPath
from typing import Any

import psutil

from plumbline.harness.history.folder import NIGHT, History, Pool, holder, opened
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError, read_journal
from plumbline.harness.store.record import digest

_OWN = ("lock",)
_GROWING = ("history.json", "acknowledged.jsonl")
"""Files that may be another without being longer or shorter."""


def is_elsewhere(address: str) -> bool:
    """Is it an address, and no folder of this machine?"""
    return "://" in address


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """A history at an address. Terms: files: fsspec's file system. path: there. root: of the copy here."""

    files: Any
    path: str
    root: Path

    def fetch(self) -> None:
        """Bring what is new there into the copy. Raises: OSError."""
        if not self.files.exists(self.path):
            return
        for name, size in self._there().items():
            mine = self.root / name
            if name in _OWN or (name not in _GROWING and mine.is_file() and mine.stat().st_size == size):
                continue
            disk.make_folder(mine.parent)
            disk.write_atomically(mine, self.files.cat_file(f"{self.path}/{name}"))
        self._lay_out()

    def send(self, *, remove: bool = False) -> None:
        """Take what is new in the copy there. Args: remove: also take away there what the copy has no more. Raises: OSError."""
        there = self._there() if self.files.exists(self.path) else {}
        mine = {str(path.relative_to(self.root)): path for path in sorted(self.root.rglob("*")) if path.is_file()}
        mine = {name: path for name, path in mine.items() if name not in _OWN and not _laid_out(name)}
        for name in sorted(mine, key=_order):
            if name in _GROWING or there.get(name) != mine[name].stat().st_size:
                self.files.makedirs(str(PurePosixPath(f"{self.path}/{name}").parent), exist_ok=True)
                self.files.pipe_file(f"{self.path}/{name}", disk.read(mine[name]))
        for name in sorted(there.keys() - mine.keys() - {*_OWN}) if remove else ():
            self.files.rm_file(f"{self.path}/{name}")

    @contextmanager
    def locked(self, seconds: float) -> Iterator[None]:
        """Hold the address for so long at most: a holder that died holds it until then, on its own machine not at all.

        Raises: StoreError, where another one holds it.
        """
        place = f"{self.path}/lock"
        if self.files.exists(place) and (said := _standing(self.files.cat_file(place))):
            raise StoreError(f"{self.path}: another night holds it ({said}); wait for its end")
        until = (datetime.now(UTC) + timedelta(seconds=seconds)).isoformat(timespec="seconds")
        mine = json.dumps(holder() | {"until": until}).encode()
        self.files.makedirs(self.path, exist_ok=True)
        self.files.pipe_file(place, mine)
        if self.files.cat_file(place) != mine:
            raise StoreError(f"{self.path}: another night began at the same moment; wait for its end")
        try:
            yield
        finally:
            self.files.rm_file(place)

    def _there(self) -> dict[str, int]:
        """Sizes of all files there, by their names below the history."""
        found = self.files.find(self.path, detail=True)
        before = self.files._strip_protocol(self.path).rstrip("/") + "/"
        return {name.removeprefix(before): int(about["size"]) for name, about in found.items()}

    def _lay_out(self) -> None:
        """Lay the trajectories of the pool into the nights that keep them."""
        history = History(self.root)
        for night in history.nights():
            hashes = {r.trajectory_hash for r in read_journal(night.folder / "journal.jsonl").values() if r.trajectory_kept}
            for name in sorted(str(name) for name in hashes - {None}):
                kept = Pool(history.pool).trajectory_path(name)
                path = night.folder / "trajectories" / f"{name}.npz"
                if kept.is_file() and not path.is_file():
                    disk.make_folder(path.parent)
                    os.link(kept, path)


def copy_of(address: str) -> Elsewhere:
    """The address with the folder of its copy. Raises: StoreError, where nothing reaches it."""
    import fsspec  # late: a history on this machine does not pay for it
    from platformdirs import user_cache_path

    try:
        files, path = fsspec.core.url_to_fs(address)
    except (ImportError, ValueError) as error:
        raise StoreError(f"{address}: not reached: {error}") from error
    root = user_cache_path("plumbline") / "histories" / digest(address)
    disk.make_folder(root)
    return Elsewhere(files, path.rstrip("/"), root)


def at_hand(address: str) -> History:
    """The history at an address, fetched where it lies elsewhere. Raises: NoRun, StoreError, OSError."""
    if not is_elsewhere(address):
        return opened(Path(address))
    elsewhere = copy_of(address)
    elsewhere.fetch()
    return opened(elsewhere.root)


def _laid_out(name: str) -> bool:
    """Is it a night's own trajectory, which the pool has, or a draft?"""
    parts = PurePosixPath(name).parts
    return parts[-1].startswith(".") or (parts[0] == "nights" and "trajectories" in parts)


def _order(name: str) -> tuple[int, str]:
    """Answers, then what nights hold, then what says that they are whole."""
    return (2 if name.endswith(f"/{NIGHT}") else 0 if name.startswith("pool/") else 1), name


def _standing(content: bytes) -> str:
    """Who holds a lock still; '' for nobody."""
    try:
        said = json.loads(content)
        lapsed = datetime.fromisoformat(said["until"]) < datetime.now(UTC)
        mine = said["host"] == holder()["host"]
        dead = mine and not psutil.pid_exists(int(said["process"]))
        return "" if lapsed or dead else f"process {said['process']} on {said['host']} until {said['until']}"
    except (ValueError, KeyError, TypeError):
        return ""
