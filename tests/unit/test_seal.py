"""Seals: whatever happens to a file is noticed, and who reads the format knows nothing of the seal."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from harness.store.arrays import read_arrays, write_arrays
from harness.store.seal import Damaged, check_seal, sealed_archive, sealed_json, sealed_toml


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


def test_a_damaged_archive_is_damaged_with_and_without_a_seal(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    whole = files(tmp_path)[path]
    path.write_bytes(whole[:60] + b"?" + whole[61:])
    with pytest.raises(Damaged):
        read_arrays(path)
    np.savez(path, x=np.arange(20.0))
    plain = path.read_bytes()
    assert [*read_arrays(path)] == ["x"]
    assert check_seal(path, sealed_archive("a.npz", plain))
    path.write_bytes(plain[: len(plain) // 2])
    with pytest.raises(Damaged):
        read_arrays(path)
