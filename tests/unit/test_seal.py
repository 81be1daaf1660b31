"""Seals: whatever happens to a file is noticed, and who reads the format knows nothing of the seal."""

import io
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.store.arrays import read_arrays, write_arrays
from plumbline.harness.store.seal import Damaged, check_seal, sealed_archive, sealed_json, sealed_toml


def files(folder: Path) -> dict[Path, bytes]:
    write_arrays(folder / "a.npz", {"x": np.arange(20.0), "scene": np.array("a scene")})
    content = {folder / "a.json": sealed_json("a.json", {"b": 1}), folder / "a.toml": sealed_toml("a.toml", "b = 1\n")}
    return {folder / "a.npz": (folder / "a.npz").read_bytes()} | content


def test_readers_of_the_format_read_on(tmp_path: Path) -> None:
    kept = files(tmp_path)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        assert arrays.files == ["x", "scene"]
    assert json.loads(kept[tmp_path / "a.json"])["b"] == 1
    assert tomllib.loads(kept[tmp_path / "a.toml"].decode()) == {"b": 1}


def test_a_bit_that_flips_anywhere_breaks_the_seal_or_hides_it(tmp_path: Path) -> None:
    """A file whose seal is not to be seen is none of a store whose files have one; see `harness.run.verify`."""
    for path, whole in files(tmp_path).items():
        assert check_seal(path, whole)
        for place in range(len(whole)):
            flipped = whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :]
            try:
                assert not check_seal(path, flipped), (path, place)
            except Damaged:
                continue
            assert len(whole) - place < 100, (path, place)


def test_a_file_that_is_cut_or_has_another_name_is_not_what_was_written(tmp_path: Path) -> None:
    for path, whole in files(tmp_path).items():
        with pytest.raises(Damaged, match="checksum differs"):
            check_seal(path.with_name(f"b{path.suffix}"), whole)
        for size in (0, 1, len(whole) // 2, len(whole) - 1):
            assert not check_seal(path, whole[:size])


ARRAYS = (
    np.arange(24.0).reshape(2, 3, 4),
    np.asfortranarray(np.arange(6).reshape(2, 3)),
    np.zeros((0, 3)),
    np.array([True, False]),
    np.array(0.25),
    np.array("a scene é"),
    np.arange(70_000, dtype=np.int32),
)


@pytest.mark.parametrize("array", ARRAYS, ids=lambda array: f"{array.dtype}{array.shape}")
def test_arrays_of_a_sealed_file_are_what_numpy_reads_and_may_be_written_to(tmp_path: Path, array: np.ndarray) -> None:
    path = tmp_path / "a.npz"
    write_arrays(path, {"before": np.ones(3), "x": array})
    with np.load(path, allow_pickle=False) as loaded:
        expected = loaded["x"]
    for read in (read_arrays(path)["x"], read_arrays(path, ["x"])["x"]):
        assert (read.dtype, read.shape, read.tobytes()) == (expected.dtype, expected.shape, expected.tobytes())
        assert read.flags.writeable


def test_a_sealed_archive_that_is_packed_is_read_and_one_of_objects_is_not(tmp_path: Path) -> None:
    path, buffer = tmp_path / "a.npz", io.BytesIO()
    np.savez_compressed(buffer, x=np.arange(20.0))
    path.write_bytes(sealed_archive("a.npz", buffer.getvalue()))
    assert (read_arrays(path)["x"] == np.arange(20.0)).all()
    buffer = io.BytesIO()
    np.savez(buffer, x=np.array([{}], dtype=object))
    path.write_bytes(sealed_archive("a.npz", buffer.getvalue()))
    with pytest.raises(Damaged, match="Object arrays"):
        read_arrays(path)


def test_a_damaged_archive_is_damaged_with_and_without_a_seal(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    whole = files(tmp_path)[path]
    path.write_bytes(whole[:60] + b"?" + whole[61:])
    for sealed in (True, False):
        with pytest.raises(Damaged):
            read_arrays(path, sealed=sealed)
    np.savez(path, x=np.arange(20.0))
    plain = path.read_bytes()
    assert [*read_arrays(path, sealed=False)] == ["x"]
    with pytest.raises(Damaged, match="no checksum"):
        read_arrays(path)
    assert check_seal(path, sealed_archive("a.npz", plain))
    path.write_bytes(plain[: len(plain) // 2])
    for sealed in (True, False):
        with pytest.raises(Damaged):
            read_arrays(path, sealed=sealed)
