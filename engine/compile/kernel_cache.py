"""Compiled code on disk, each file with a digest of its name and content: what was damaged is compiled anew, never run.

Numba's own cache unpickles whatever its files hold; a flipped bit there is an exception, or other machine code.
"""

import hashlib
import os
import warnings
from pathlib import Path

_DIGITS = 64


def _digest(name: str, content: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode()


def read_checked(path: Path) -> bytes | None:
    """What was written to a file; None, with a warning, where it holds something else. Raises: OSError."""
    content = path.read_bytes()
    if content[:_DIGITS] == _digest(path.name, content[_DIGITS:]):
        return content[_DIGITS:]
    warnings.warn(f"{path}: compiled code is damaged (its checksum differs); it is compiled anew", RuntimeWarning, stacklevel=2)
    return None


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_checked(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, with its digest. Raises: OSError."""
    draft = path.with_name(f"{path.name}.tmp.{os.getpid()}")
    try:
        draft.write_bytes(_digest(path.name, content) + content)
        _sync(draft)
        draft.replace(path)
        _sync(path.parent)
    finally:
        draft.unlink(missing_ok=True)
