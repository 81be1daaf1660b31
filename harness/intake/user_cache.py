"""What this program keeps in the user's cache folder: taken over where it is whole, and nobody else can have written it.

Each file begins with a digest of its name and of the rest. That keeps no secret: what another user wrote has a right one too,
and is told by who owns and who may write the file and its folder.
"""

import hashlib
import os
import stat
import warnings
from contextlib import suppress
from functools import cache
from pathlib import Path

import platformdirs

_DIGEST = 32


def cache_folder(room: str) -> Path:
    """The folder of what is kept of one kind; it may not be there."""
    return Path(platformdirs.user_cache_dir("plumbline")) / room


def is_ours(path: Path) -> bool:
    """Is it a file or folder of this user or of root that nobody else may write to, in a folder of which the same holds?"""
    with suppress(OSError):
        return all(_alone(each.stat()) for each in (path, path.parent))
    return False


def _alone(status: os.stat_result) -> bool:
    return status.st_uid in (0, os.geteuid()) and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def make_ours(path: Path) -> None:
    """Let nobody else write to a file or folder that was just made. Raises: OSError."""
    path.chmod(stat.S_IMODE(path.stat().st_mode) & ~(stat.S_IWGRP | stat.S_IWOTH))


def read_kept(path: Path) -> bytes | None:
    """What was kept; None where nothing was, where it is damaged, and where another user may have written it."""
    with suppress(OSError):
        if not path.is_file():
            return None
        if not is_ours(path):
            _say_once(f"{path.parent}: what another user owns or may write is not taken over; it is made anew")
            return None
        content = path.read_bytes()
        return content[_DIGEST:] if content[:_DIGEST] == _digest(path, content[_DIGEST:]) else None
    return None


@cache
def _say_once(text: str) -> None:
    warnings.warn(text, RuntimeWarning, stacklevel=3)


def keep(path: Path, content: bytes) -> None:
    """Keep it, all or nothing; where that cannot be done it is made anew each time."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    with suppress(OSError):
        for folder in (path.parent.parent, path.parent):
            folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o644), "wb") as file:
            file.write(_digest(path, content) + content)
        draft.replace(path)
        return
    with suppress(OSError):
        draft.unlink()


def _digest(path: Path, content: bytes) -> bytes:
    return hashlib.sha256(path.name.encode() + b"\0" + content).digest()
