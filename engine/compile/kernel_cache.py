"""Compiled code on disk, each file with a digest of its name and content: what was damaged, or is another's, is compiled anew.

Numba's own cache unpickles whatever its files hold; a flipped bit there is an exception, or other machine code. A digest keeps
no secret: what another user wrote has a right one too, and is told by who owns and who may write the file and its folder.
"""

import hashlib
import os
import stat
import warnings
from contextlib import suppress
from functools import cache
from pathlib import Path

import platformdirs

VARIABLE = "PLUMBLINE_KERNEL_CACHE"
"""The variable that names another folder than the user's own."""
_DIGITS = 64


class NoFolder(OSError):
    """There is no folder for compiled code; the message says why, and which variable to set."""


def is_ours(path: Path) -> bool:
    """Is it owned by this user or root, and may nobody else write to it? Raises: OSError."""
    status = path.stat()
    return status.st_uid in (0, os.geteuid()) and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def root() -> Path:
    """The folder that all compiled code lies in: the one that `VARIABLE` names, or the user's own, where nobody else may write
    to it; one of this user's within it elsewhere."""
    folder = Path(os.environ.get(VARIABLE) or platformdirs.user_cache_dir("plumbline")).absolute()
    return folder / f"user-{os.geteuid()}" if folder.is_dir() and not is_ours(folder) else folder


def usable_root() -> Path:
    """The same; one that is there may be read-only, and what it lacks is compiled each time. Raises: NoFolder."""
    folder = root()
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        whose = "" if is_ours(folder) else f"{folder} is another user's, or others may write to it"
    except OSError as error:
        whose = f"{folder}: {error.strerror}"
    if whose:
        raise NoFolder(
            f"{VARIABLE}: {os.environ.get(VARIABLE, '')[:200]!r}: {whose}; name a folder of your own, or one to be made"
        )
    return folder


def make_directory(directory: Path) -> None:
    """A directory in `root`, and that, unless they are there; nobody else may write to what is made. Raises: OSError."""
    for folder in (directory.parent, directory):
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)


def read_checked(path: Path) -> bytes | None:
    """What was written to a file; None, with a warning, where it holds something else, or is another's. Raises: OSError."""
    if not stat.S_ISREG(path.stat().st_mode) or not (is_ours(path.parent) and is_ours(path)):
        _say_once(f"{path.parent}: compiled code that another user owns or may write is not run; it is compiled anew")
        return None
    content = path.read_bytes()
    if content[:_DIGITS] == _digest(path.name, content[_DIGITS:]):
        return content[_DIGITS:]
    warnings.warn(f"{path}: compiled code is damaged (its checksum differs); it is compiled anew", RuntimeWarning, stacklevel=2)
    return None


def write_checked(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, with its digest; where it cannot be kept, each process compiles, and is told so."""
    draft = path.with_name(f"{path.name}.tmp.{os.getpid()}")
    try:
        make_directory(path.parent)
        with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), "wb") as file:
            file.write(_digest(path.name, content) + content)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
        _sync(path.parent)
    except OSError as error:
        _say_once(f"{path.parent}: compiled code cannot be kept: {error.strerror}")
        with suppress(OSError):
            draft.unlink()


@cache
def _say_once(text: str) -> None:
    warnings.warn(text, RuntimeWarning, stacklevel=4)


def _digest(name: str, content: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode()


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
