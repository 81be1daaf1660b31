"""Environments of engine versions that nobody asks for any more: those of another lock, after a while."""

import fcntl
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from plumbline.harness.study.environments import folder_of, root


@dataclass(frozen=True, slots=True)
class OldEnvironment:
    """Terms: folder. unasked [s]: since a run last asked for it. bytes: on the disk."""

    folder: Path
    unasked: float
    bytes: int


def old_environments(older: float) -> Iterator[OldEnvironment]:
    """Those that the lock, the numeric libraries and Python of this installation do not lead to, unasked for so long [s].

    Another installation of the same user may have others: what it asked for within that time is not among them.
    """
    for folder in sorted(path for path in root().glob("*") if path.is_dir()):
        unasked = time.time() - _asked(folder)
        if unasked >= older and folder not in map(folder_of, _names(folder)):
            size = sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file())
            yield OldEnvironment(folder, unasked, size)


def remove(old: OldEnvironment) -> bool:
    """Take it away, unless a run is making or trying it: was it taken? Raises: OSError."""
    with _lock_of(old.folder).open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        shutil.rmtree(old.folder)
        _lock_of(old.folder).unlink()
    return True


def _lock_of(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.lock")


def _asked(folder: Path) -> float:
    """When a run last asked for it: whoever does opens its lock anew."""
    lock = _lock_of(folder)
    return (lock if lock.is_file() else folder).stat().st_mtime


def _names(folder: Path) -> Iterator[str]:
    """What the engine in a folder may be called: one of the hyphens stands for the blank, if it has a version."""
    words = folder.name.rpartition("-")[0].split("-")
    yield "-".join(words)
    yield from ("-".join(words[:k]) + " " + "-".join(words[k:]) for k in range(1, len(words)))
