"""A trajectory on disk: one npz of float64 arrays with its scene and its truth, named by the hash of what the engine said."""

import hashlib
import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.scene import Scene
from plumbline.harness.scene.file import dump_json
from plumbline.harness.store.arrays import read_arrays, write_arrays
from plumbline.harness.store.seal import Damaged
from plumbline.harness.trajectory import Contacts, Trajectory

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
