"""Arrays on disk: npz files with a seal, read back only where it holds."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.store import disk
from harness.store.journal import StoreError
from harness.store.seal import Damaged, check_seal, sealed_archive

__all__ = ["read_arrays", "write_arrays"]


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write the arrays and their seal, whole or not at all. Raises: StoreError, where the machine does not let it."""

    def archive() -> bytes:
        buffer = io.BytesIO()
        np.savez(buffer, **arrays)  # type: ignore[arg-type]  # the stub takes the keyword 'allow_pickle' for one of them
        return sealed_archive(path.name, buffer.getvalue())

    try:
        disk.make_folder(path.parent)
        disk.write_atomically(path, disk.calls.filled(archive))
    except OSError as error:
        raise StoreError(f"{path}: not written: {error.strerror or error}; mend that, and --resume runs its trial") from error


def read_arrays(path: Path, only: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
    """The arrays of these names, or all. Raises: Damaged, where the file is not what was written; OSError."""
    content = disk.read(path)
    check_seal(path, content)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in only or arrays.files}
    except MemoryError:
        raise
    except Exception as error:  # a file without a seal may break its reader anywhere
        raise Damaged(f"{type(error).__name__}: {error}") from error
