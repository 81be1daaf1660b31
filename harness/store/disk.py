"""How a run folder is written: what is here when a function returns stays, whatever happens to the process or the power.

Every call that the store makes to the system goes through `calls`, one method each, so that a test can let the n-th one fail or
forget what was never synchronised.
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from errno import EINVAL
from pathlib import Path
from typing import BinaryIO, TypeVar

Made = TypeVar("Made")


class Calls:
    """What is asked of the system, and of its memory where much of it is wanted at once."""

    def open(self, path: Path, flags: int) -> int:
        """A descriptor of a file or, to be synchronised, of a folder."""
        return os.open(path, flags, 0o666)

    def write(self, descriptor: int, content: memoryview) -> int:
        """How many bytes were taken."""
        return os.write(descriptor, content)

    def sync(self, descriptor: int) -> None:
        """Return when all of a file, or the names in a folder, are on the disk."""
        os.fsync(descriptor)

    def rename(self, old: Path, new: Path) -> None:
        """Give a file or folder another name, in place of what had it."""
        old.replace(new)

    def truncate(self, descriptor: int, size: int) -> None:
        """Cut a file to `size` bytes."""
        os.ftruncate(descriptor, size)

    def make(self, folder: Path) -> None:
        """A new folder."""
        folder.mkdir()

    def remove(self, path: Path) -> None:
        """Take a file away."""
        path.unlink()

    def read(self, path: Path) -> bytes:
        """All of a file."""
        return path.read_bytes()

    def reader(self, path: Path) -> BinaryIO:
        """A file to be read from its beginning on."""
        return path.open("rb")

    def filled(self, make: Callable[[], Made]) -> Made:
        """What takes memory of the size of a file."""
        return make()


calls = Calls()
"""Those in use."""


def _sync_path(path: Path) -> None:
    descriptor = calls.open(path, os.O_RDONLY)
    try:
        calls.sync(descriptor)
    finally:
        os.close(descriptor)


def _write(descriptor: int, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[calls.write(descriptor, left) :]


def put_in_place(draft: Path, path: Path) -> None:
    """Give a file or folder that is written its name, in place of a file that had it; what is in it is on the disk before."""
    if draft.is_dir():
        for inside in [*sorted(draft.rglob("*")), draft]:
            _sync_path(inside)
    else:
        _sync_path(draft)
    calls.rename(draft, path)
    _sync_path(path.parent)


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that a kill or a power cut leaves the old one or the new one, never a part. Raises: OSError."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        descriptor = calls.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW)
        try:
            _write(descriptor, content)
        finally:
            os.close(descriptor)
        put_in_place(draft, path)
    except BaseException:
        with suppress(OSError):
            calls.remove(draft)
        raise


def make_folder(folder: Path) -> None:
    """A folder, with those that it lies in, unless it is there."""
    if folder.is_dir():
        return
    make_folder(folder.parent)
    with suppress(FileExistsError):
        calls.make(folder)
    _sync_path(folder.parent)


def remove(path: Path) -> None:
    """Take a file away for good, unless it is not there."""
    with suppress(FileNotFoundError):
        calls.remove(path)
        _sync_path(path.parent)


def read(path: Path) -> bytes:
    """All of a file. Raises: OSError, also for what is none: of a pipe, nothing might ever come."""
    if path.exists() and not path.is_file():
        raise OSError(EINVAL, "is no regular file", str(path))
    return calls.filled(lambda: calls.read(path))


def digest(path: Path) -> str:
    """The SHA-256 of a file's bytes. Raises: OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class Appended:
    """A file that grows at its end only, by whole pieces.

    Terms: size: bytes that are on the disk. waits: each piece is on the disk before the next; else all are once it is closed.
    Where a piece fails, what came of it is cut off again; where that cannot be done
    either, nothing more is taken, since a piece behind half a piece could not be told apart from it.
    """

    def __init__(self, path: Path, *, waits: bool = True) -> None:
        """Open or create. Raises: OSError."""
        self.waits = waits
        new = not path.exists()
        self.descriptor = calls.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self.size = os.fstat(self.descriptor).st_size
        self._broken = False
        try:
            if new:
                _sync_path(path.parent)
        except BaseException:
            self.close()
            raise

    def cut(self, size: int) -> None:
        """Drop all behind the first `size` bytes."""
        calls.truncate(self.descriptor, size)
        calls.sync(self.descriptor)
        self.size = size

    def append(self, piece: bytes) -> None:
        """Write a piece through to the disk. Raises: OSError."""
        if self._broken:
            raise OSError("an earlier piece could not be written, nor taken back; open the file anew")
        try:
            _write(self.descriptor, piece)
            if self.waits:
                calls.sync(self.descriptor)
        except BaseException:
            self._broken = True
            self.cut(self.size)
            self._broken = False
            raise
        self.size += len(piece)

    def close(self) -> None:
        """May be called twice. Raises: OSError."""
        if self.descriptor >= 0:
            if not self.waits:
                calls.sync(self.descriptor)
            os.close(self.descriptor)
            self.descriptor = -1
