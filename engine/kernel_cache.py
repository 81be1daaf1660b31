"""Compiled code on disk, each file with a digest of its name and content: what was damaged is compiled anew, never run.

Numba's own cache unpickles whatever its files hold; a flipped bit there is an exception, or other machine code.
"""

import hashlib
import io
import os
import pickle
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

__all__ = ["check_files"]

_DIGITS = 64


def check_files(kept: Any) -> None:
    """Let a compiled function's cache (Numba's `FunctionCache`) write and read files with digests from here on."""
    kept._cache_file.__class__ = _checked_files()


def _digest(name: str, content: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode()


def _read(path: Path) -> bytes | None:
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


@cache
def _checked_files() -> type:
    from numba.core.caching import IndexDataCacheFile

    files: Any = IndexDataCacheFile

    class Checked(files):  # type: ignore[misc]  # Numba is untyped
        """Numba's index and data files, behind digests."""

        def _load_index(self) -> dict[Any, str]:
            try:
                content = _read(Path(self._index_path))
            except FileNotFoundError:
                return {}
            if content is None:
                return {}
            stream = io.BytesIO(content)
            if pickle.load(stream) != self._version:
                return {}
            stamp, overloads = pickle.loads(stream.read())
            return overloads if stamp == self._source_stamp else {}

        def _load_data(self, name: str) -> Any:
            path = Path(self._data_path(name))
            content = _read(path)
            if content is None:
                raise OSError(f"{path}: damaged")  # what Numba takes for a file that is not there
            return pickle.loads(content)

        @contextmanager
        def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
            buffer, path = io.BytesIO(), Path(filepath)
            yield buffer
            draft = path.with_name(f"{path.name}.tmp.{os.getpid()}")
            try:
                content = buffer.getvalue()
                draft.write_bytes(_digest(path.name, content) + content)
                _sync(draft)
                draft.replace(path)
                _sync(path.parent)
            finally:
                draft.unlink(missing_ok=True)

    return Checked
