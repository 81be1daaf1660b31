"""Arrays on disk: npz files with a seal, read back only where it holds."""

import io
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import Damaged, check_seal, sealed_archive


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


def read_arrays(path: Path, only: Sequence[str] = (), *, sealed: bool = True) -> dict[str, NDArray[Any]]:
    """The arrays of these names, or all. Args: sealed: must it have a seal? Those of other programs have none.

    Raises: Damaged, where the file is not what was written; OSError.
    """
    content = disk.read(path)
    if not check_seal(path, content) and sealed:
        raise Damaged("it has no checksum")
    try:
        if sealed and (arrays := _stored(content, only)) is not None:
            return arrays
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in only or arrays.files}
    except MemoryError:
        raise
    except Exception as error:  # a file without a seal may break its reader anywhere
        raise Damaged(f"{type(error).__name__}: {error}") from error


def _stored(content: bytes, only: Sequence[str]) -> dict[str, NDArray[Any]] | None:
    """The arrays of an archive that keeps them as they are, as ours do; None of any other.

    Its seal holds, so that the checksum of each member, which `numpy.load` works out byte by byte, says nothing more.
    """
    with ZipFile(io.BytesIO(content)) as archive:
        members = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}
    if any(member.compress_type != ZIP_STORED for member in members.values()):
        return None
    return {name: _array(content, members[name]) for name in only or members}


def _array(content: bytes, member: ZipInfo) -> NDArray[Any]:
    lengths = member.header_offset + 26  # of its name and of what else stands before it
    start = lengths + 4 + sum(int.from_bytes(content[at : at + 2], "little") for at in (lengths, lengths + 2))
    long = 2 if content[start + 6] == 1 else 4  # bytes of the header's length: by the version of the format
    head = start + 8 + long + int.from_bytes(content[start + 8 : start + 8 + long], "little")
    shape, by_columns, kind = _header(content[start:head])
    numbers = np.frombuffer(content, kind, math.prod(shape), head)
    return numbers.reshape(shape, order="F" if by_columns else "C").copy()


@lru_cache(maxsize=1024)
def _header(head: bytes) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, order and kind of an array as its file begins; alike in many files."""
    stream = io.BytesIO(head)
    version = npy.read_magic(stream)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, by_columns, kind = read(stream, max_header_size=len(head))
    if kind.hasobject:
        raise ValueError("it holds objects")
    return shape, by_columns, kind
