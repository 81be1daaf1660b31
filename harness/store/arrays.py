"""Arrays on disk: npz files with a seal, read back only where it holds. A trajectory is one with its scene and its truth,
named by the hash of what the engine said.
"""

import hashlib
import io
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import dump_json
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import Damaged, check_seal, sealed_archive
from plumbline.harness.trajectory import Contacts, Trajectory


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
    (stream := io.BytesIO(content)).seek(start)
    array: NDArray[Any] = npy.read_array(stream, allow_pickle=False, max_header_size=len(content))
    return array


_STATES = ("time", "p_WB", "q_WB", "v_WB", "w_WB")
_STREAM = "stream:"
_CONTACTS = ("body_A", "body_B", "point_W", "normal_W", "gap", "force_W")


def _ragged(contacts: tuple[Contacts, ...]) -> dict[str, NDArray[Any]]:
    """Contacts of all instants behind each other, with their number at each instant under 'contacts_count'."""
    arrays: dict[str, NDArray[Any]] = {"contacts_count": np.array([len(c) for c in contacts], dtype=np.int64)}
    for name in _CONTACTS:
        arrays[f"contacts_{name}"] = np.concatenate([getattr(c, name) for c in contacts])
    return arrays


def _arrays(trajectory: Trajectory) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {name: getattr(trajectory, name) for name in _STATES}
    if trajectory.contacts:
        arrays |= _ragged(trajectory.contacts)
    arrays |= {f"{_STREAM}{name}": signal for name, signal in trajectory.streams.items()}
    return {name: np.ascontiguousarray(array) for name, array in arrays.items()}


def _trajectory(arrays: Mapping[str, NDArray[Any]], dt: float, even: bool = True) -> Trajectory:
    """What `_arrays` was given, in memory as a file has it."""
    contacts = None
    if "contacts_count" in arrays:
        ends = np.cumsum(arrays["contacts_count"]).tolist()
        columns = [arrays[f"contacts_{name}"] for name in _CONTACTS]
        contacts = tuple(Contacts(*(c[start:end] for c in columns)) for start, end in pairwise([0, *ends]))
    streams = {name.removeprefix(_STREAM): signal for name, signal in arrays.items() if name.startswith(_STREAM)}
    time, p_WB, q_WB, v_WB, w_WB = (arrays[name] for name in _STATES)
    return Trajectory(time, p_WB, q_WB, v_WB, w_WB, dt=dt, contacts=contacts, streams=streams, even=even)


def as_kept(trajectory: Trajectory) -> Trajectory:
    """The same trajectory, laid out in memory as it is once it is read back: so sums over it have the same bits."""
    return _trajectory(_arrays(trajectory), trajectory.dt, trajectory.even)


def read_trajectory(folder: Path, name: str, scene: Scene) -> Trajectory | None:
    """The answer of this hash, without its truth, under even steps; None where its file is gone or damaged, holds another
    answer than its name says, or the answer to another scene."""
    try:
        arrays = read_arrays(folder / "trajectories" / f"{name}.npz")
        actual = _trajectory(arrays, float(arrays["dt"]))
        return actual if trajectory_hash(scene, actual) == name else None
    except (Damaged, OSError, KeyError, ValueError):
        return None


def trajectory_hash(scene: Scene, trajectory: Trajectory) -> str:
    """Sixteen hexadecimal digits of the scene and every bit of the answer; equal hashes are bit-identical runs."""
    return _hash(dump_json(scene), _arrays(trajectory))


def kept_hash(arrays: Mapping[str, NDArray[Any]]) -> str:
    """The same of the arrays of a file. Raises: KeyError, where it has no scene."""
    hashed = {name: array for name, array in arrays.items() if name not in ("scene", "dt") and not name.startswith("truth_")}
    return _hash(str(arrays["scene"]), hashed)


def _hash(scene: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    sha = hashlib.sha256(scene.encode())
    for name, array in sorted(arrays.items()):
        sha.update(f"{name}{array.dtype}{array.shape}".encode())
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()[:16]


def save_trajectory(folder: Path, scene: Scene, actual: Trajectory, expected: Trajectory | None) -> str:
    """Write <folder>/trajectories/<hash>.npz and return the hash. Raises: OSError."""
    name = trajectory_hash(scene, actual)
    arrays = _arrays(actual) | {"scene": np.array(dump_json(scene)), "dt": np.array(actual.dt)}
    if expected is not None:
        arrays |= {f"truth_{key}": value for key, value in _arrays(expected).items() if math.prod(value.shape)}
    write_arrays(folder / "trajectories" / f"{name}.npz", arrays)
    return name
