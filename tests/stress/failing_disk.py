"""Disks that fail: the n-th call of the store, or all from there on; and a power cut that forgets what was not synchronised."""

import errno
import os
import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from plumbline.harness.store.disk import Calls

__all__ = ["ERRORS", "Counting", "Failing", "Losing", "PowerCut"]

ERRORS: dict[str, Callable[[], BaseException]] = {
    "ENOSPC": lambda: OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
    "EIO": lambda: OSError(errno.EIO, os.strerror(errno.EIO)),
    "MemoryError": MemoryError,
}


class PowerCut(BaseException):
    """Nothing of this process happens from here on."""


class Counting(Calls):
    """Tells each call before it happens. Terms: seen: their names, in order."""

    def __init__(self) -> None:
        self.seen: list[str] = []

    def before(self, name: str) -> bool:
        """Note a call; does it happen?"""
        self.seen.append(name)
        return True

    def open(self, path: Path, flags: int) -> int:
        self.before("open")
        return super().open(path, flags)

    def write(self, descriptor: int, content: memoryview) -> int:
        self.before("write")
        return super().write(descriptor, content)

    def sync(self, descriptor: int) -> None:
        self.before("sync")  # that is all: no power goes for real

    def rename(self, old: Path, new: Path) -> None:
        self.before("rename")
        super().rename(old, new)

    def truncate(self, descriptor: int, size: int) -> None:
        self.before("truncate")
        super().truncate(descriptor, size)

    def make(self, folder: Path) -> None:
        self.before("make")
        super().make(folder)

    def remove(self, path: Path) -> None:
        self.before("remove")
        super().remove(path)

    def read(self, path: Path) -> bytes:
        self.before("read")
        return super().read(path)

    def reader(self, path: Path) -> BinaryIO:
        self.before("read")
        return super().reader(path)

    def filled(self, make: Callable[[], Any]) -> Any:
        self.before("allocation")
        return super().filled(make)


class Failing(Counting):
    """The n-th call fails, and every later one where the fault stays; a write has done half of its work by then.

    Terms: met: the name of the call that failed, '' before.
    """

    def __init__(self, number: int, error: str, stays: bool) -> None:
        super().__init__()
        self.number, self.error, self.stays, self.met = number, error, stays, ""

    def before(self, name: str) -> bool:
        super().before(name)
        count = len(self.seen)
        if count == self.number or (self.stays and count > self.number):
            self.met = self.met or name
            raise ERRORS[self.error]()
        return True

    def write(self, descriptor: int, content: memoryview) -> int:
        if len(self.seen) + 1 == self.number:
            os.write(descriptor, content[: len(content) // 2])
        return super().write(descriptor, content)


@dataclass(slots=True)
class _Inode:
    """A file or folder. Terms: synced: what of it is on the disk for certain; None for a folder."""

    synced: bytes | None = b""


@dataclass(slots=True)
class _Model:
    """What the disk has for certain, beside what the system shows."""

    shown: dict[Path, _Inode] = field(default_factory=dict)
    kept: dict[Path, _Inode] = field(default_factory=dict)


class Losing(Counting):
    """The power goes at the n-th call. `settle` then leaves what a disk may hold of what was done.

    A file keeps what it held when it was last synchronised, and perhaps a part of what came behind; a name is kept that was
    given before its folder was last synchronised. Terms: names_first: later names have reached the disk all the same.
    """

    def __init__(self, number: int, base: Path, names_first: bool) -> None:
        super().__init__()
        self.number, self.base, self.names_first = number, base, names_first
        self._model, self._open = _Model(), dict[int, Path]()

    def before(self, name: str) -> bool:
        if len(self.seen) >= self.number:
            raise PowerCut
        return super().before(name)

    def open(self, path: Path, flags: int) -> int:
        descriptor = super().open(path, flags)
        self._open[descriptor] = path
        if flags & os.O_CREAT:
            self._model.shown.setdefault(path, _Inode())
        return descriptor

    def sync(self, descriptor: int) -> None:
        super().sync(descriptor)
        path, model = self._open[descriptor], self._model
        if path.is_dir():
            for names in (model.kept, model.shown):
                for inside in [one for one in names if one.parent == path]:
                    if inside in model.shown:
                        model.kept[inside] = model.shown[inside]
                    else:
                        del model.kept[inside]
        else:
            model.shown[path].synced = path.read_bytes()

    def rename(self, old: Path, new: Path) -> None:
        super().rename(old, new)
        self._model.shown[new] = self._model.shown.pop(old)

    def make(self, folder: Path) -> None:
        super().make(folder)
        self._model.shown[folder] = _Inode(None)

    def remove(self, path: Path) -> None:
        super().remove(path)
        self._model.shown.pop(path, None)

    def settle(self, chance: random.Random) -> None:
        """Make the folder what is found when the power is back."""
        model = self._model
        now = {path: path.read_bytes() for path in model.shown if path.is_file()}
        by_inode = {id(inode): now[path] for path, inode in model.shown.items() if path in now}
        names = model.shown if self.names_first else model.kept
        shutil.rmtree(self.base, ignore_errors=True)
        for path, inode in sorted(names.items()):
            if not path.parent.is_dir():
                continue
            if inode.synced is None:
                path.mkdir()
                continue
            path.write_bytes(_torn(inode.synced, by_inode.get(id(inode), inode.synced), chance))


def _torn(synced: bytes, shown: bytes, chance: random.Random) -> bytes:
    """What is left of a file that was written to after it was synchronised."""
    if not shown.startswith(synced):
        return chance.choice((synced, shown))
    behind = shown[len(synced) :]
    part = behind[: chance.randint(0, len(behind))]
    blank = chance.randint(0, len(part))
    return synced + chance.choice((b"", part, part[:blank] + b"\0" * (len(part) - blank)))
