"""The journal: torn tails are dropped, corruption is named, nothing stands twice."""

import dataclasses
import hashlib
import json
from pathlib import Path

import pytest

from plumbline.harness.store import disk
from plumbline.harness.store.journal import Journal, StoreError, read_journal, read_written
from plumbline.harness.store.record import Measurement, Record, Sample, Timing, plain
from plumbline.harness.store.stored_tables import BESIDE, COLUMNS, flat


def record(name: str) -> Record:
    return Record(
        trial=name,
        study="s",
        experiment="e",
        case="c",
        parameters={"speed": 1.0},
        engine="x",
        engine_version="1",
        track="tuned",
        dt=0.01,
        settings={"dt": 0.01},
        status="failed",
        reason="because",
        measurements=(
            Measurement(metric="m", value=float("nan"), unit="m", at_most=1.0, passed=False),
            Measurement(metric="n", value=float("inf"), unit="m"),
        ),
    )


TIMING = Timing(
    trial="b",
    cpu_per_sim_s=0.5,
    samples=(Sample(process=0, block=0, steps=10, cpu=0.05, wall=0.05, canary=0.001, switches=0),),
)


def write(folder: Path) -> bytes:
    journal = Journal(folder)
    for name in ("a", "b", "c"):
        journal.append(record(name))
    journal.append(TIMING)
    journal.close()
    return (folder / "journal.jsonl").read_bytes()


def test_what_was_written_is_read_back_non_finite_numbers_included(tmp_path: Path) -> None:
    write(tmp_path)
    found = read_journal(tmp_path / "journal.jsonl")
    assert list(found) == ["a", "b", "c"]
    assert repr(found["a"]) == repr(record("a"))
    assert found["b"].timing == TIMING


def test_each_field_of_a_record_and_of_its_timing_has_a_column_but_those_that_are_left_out_by_name() -> None:
    of_record, of_timing = ({field.name for field in dataclasses.fields(kind)} for kind in (Record, Timing))
    wanted = (of_record - {"broke", "measurements", "timing"}) | (of_timing - {"note", "samples"}) | {"timing_note"}
    assert len(COLUMNS["trials"]) == len({*COLUMNS["trials"]})
    assert {*COLUMNS["trials"], *BESIDE} == wanted | {"notices"}
    row = flat(dataclasses.replace(record("b"), timing=dataclasses.replace(TIMING, note="late")))
    assert {*COLUMNS["trials"], *BESIDE} <= {*row}
    assert (row["cpu_per_sim_s"], row["timing_note"], row["warnings"]) == (0.5, "late", '["timing: late"]')


@pytest.mark.parametrize("apart", [7, pytest.param(1, marks=pytest.mark.slow)])
def test_a_last_line_cut_at_any_byte_is_dropped_and_the_rest_kept(tmp_path: Path, apart: int) -> None:
    whole = write(tmp_path)
    last = whole.rstrip(b"\n").rfind(b"\n") + 1
    path = tmp_path / "journal.jsonl"
    for cut in (*range(last, len(whole) - 1, apart), len(whole) - 1):
        path.write_bytes(whole[:cut])
        assert list(read_journal(path)) == ["a", "b", "c"]
        assert read_journal(path)["b"].timing is None
        journal = Journal(tmp_path)
        assert journal.dropped == cut - last
        assert journal.written.clocked_on("b") is None
        journal.close()
        assert path.read_bytes() == whole[:last]


def test_a_flipped_bit_before_the_last_line_is_named(tmp_path: Path) -> None:
    whole = bytearray(write(tmp_path))
    path = tmp_path / "journal.jsonl"
    first_line = whole.index(b"\n")
    for place in range(0, first_line, 37):
        flipped = bytearray(whole)
        flipped[place] ^= 1
        path.write_bytes(bytes(flipped))
        with pytest.raises(StoreError, match="line 1 is corrupt"):
            read_journal(path)


def test_a_newer_schema_is_refused(tmp_path: Path) -> None:
    import hashlib

    text = json.dumps({"schema": 99, "kind": "accuracy", "content": {}})
    line = f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {text}\n"
    (tmp_path / "journal.jsonl").write_text(line)
    with pytest.raises(StoreError, match="schema 99"):
        read_journal(tmp_path / "journal.jsonl")


def test_a_second_writer_is_refused_until_the_first_is_gone(tmp_path: Path) -> None:
    first = Journal(tmp_path)
    with pytest.raises(StoreError, match="another run"):
        Journal(tmp_path)
    first.close()
    Journal(tmp_path).close()


def test_a_trial_cannot_be_written_twice(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.append(record("a"))
    with pytest.raises(StoreError, match="trial a is already there"):
        journal.append(record("a"))
    journal.close()


def test_a_corrupt_last_line_is_named_and_not_dropped(tmp_path: Path) -> None:
    whole = write(tmp_path)
    path = tmp_path / "journal.jsonl"
    path.write_bytes(whole[:-20] + bytes([whole[-20] ^ 1]) + whole[-19:])
    with pytest.raises(StoreError, match=r"line 4, the last, is corrupt .*--resume run its trial anew"):
        Journal(tmp_path)
    with pytest.raises(StoreError, match="line 4, the last, is corrupt"):
        read_journal(path)


@pytest.mark.parametrize("apart", [17, pytest.param(5, marks=pytest.mark.slow)])
def test_whatever_bit_flips_is_noticed(tmp_path: Path, apart: int) -> None:
    whole = write(tmp_path)
    path = tmp_path / "journal.jsonl"
    for place in range(0, len(whole), apart):
        for bit in (0, 2, 7):
            put(path, place, whole[place] ^ 1 << bit)
            with pytest.raises(StoreError, match=r"journal\.jsonl: line [1-4]"):
                read_journal(path)
        put(path, place, whole[place])
    assert path.read_bytes() == whole


def put(path: Path, place: int, byte: int) -> None:
    """Write a byte in its place; a file that is written whole, over what it held, waits for the disk."""
    with path.open("r+b") as stream:
        stream.seek(place)
        stream.write(bytes([byte]))


def test_lines_that_are_missing_doubled_or_swapped_are_noticed(tmp_path: Path) -> None:
    lines = write(tmp_path).splitlines(keepends=True)
    path = tmp_path / "journal.jsonl"
    for k in range(len(lines) - 1):
        path.write_bytes(b"".join(lines[:k] + lines[k + 1 :]))
        with pytest.raises(StoreError, match=f"line {k + 1} is numbered {k + 2}: line {k + 1} is missing before it"):
            read_journal(path)
    for k in range(len(lines)):
        path.write_bytes(b"".join(lines[: k + 1] + lines[k:]))
        with pytest.raises(StoreError, match=f"line {k + 2} is numbered {k + 1}: it stands twice, or was moved"):
            read_journal(path)
        for j in range(k):
            moved = [*lines]
            moved[j], moved[k] = moved[k], moved[j]
            path.write_bytes(b"".join(moved))
            with pytest.raises(StoreError, match=f"line {j + 1} is numbered {k + 1}"):
                read_journal(path)


def test_a_line_of_another_run_does_not_follow(tmp_path: Path) -> None:
    lines = write(tmp_path).splitlines(keepends=True)
    other = tmp_path / "other"
    other.mkdir()
    journal = Journal(other)
    for name in ("x", "y", "z"):
        journal.append(record(name))
    journal.close()
    foreign = (other / "journal.jsonl").read_bytes().splitlines(keepends=True)
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b"".join([lines[0], foreign[1], lines[2]]))
    with pytest.raises(StoreError, match="line 2 does not follow the line before it"):
        read_journal(path)


def test_blocks_that_never_reached_the_disk_are_a_torn_tail(tmp_path: Path) -> None:
    whole = write(tmp_path)
    last = whole.rstrip(b"\n").rfind(b"\n") + 1
    path = tmp_path / "journal.jsonl"
    path.write_bytes(whole[: last + 30] + b"\0" * (len(whole) - last - 31) + b"\n")
    written = read_written(path)
    assert written.torn == len(whole) - last
    assert written.notes == (f"{path}: line 4, the last, is torn, as a kill leaves it: {written.torn} bytes are dropped",)


def test_what_is_withdrawn_can_be_run_again_or_brought_back(tmp_path: Path) -> None:
    write(tmp_path)
    journal = Journal(tmp_path)
    journal.withdraw(["a", "b"], "the engine changed")
    assert [*journal.records] == ["c"]
    journal.append(record("a"))
    journal.restore(["b"])
    journal.close()
    written = read_written(tmp_path / "journal.jsonl")
    assert sorted(written.records) == ["a", "b", "c"]
    assert written.records["b"].timing == TIMING
    assert written.withdrawn == {}


def test_a_trial_is_clocked_once_on_a_machine_and_once_more_on_another(tmp_path: Path) -> None:
    write(tmp_path)
    journal = Journal(tmp_path)
    with pytest.raises(StoreError, match="trial b is already there"):
        journal.append(TIMING)
    elsewhere = dataclasses.replace(TIMING, cpu_per_sim_s=0.25, clocked_on="another")
    journal.append(elsewhere)
    journal.close()
    written = read_written(tmp_path / "journal.jsonl")
    assert written.records["b"].timing == elsewhere
    assert [written.clocked_on(name) for name in "abc"] == [None, "another", None]


def test_the_journal_takes_nothing_more_behind_a_piece_that_it_could_not_take_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path)
    journal = Journal(tmp_path)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(disk.calls, "sync", full)
        patch.setattr(disk.calls, "truncate", full)
        with pytest.raises(OSError, match="No space"):
            journal.append(record("d"))
    with pytest.raises(OSError, match="open the file anew"):
        journal.append(record("e"))
    journal.close()
    assert "e" not in read_journal(tmp_path / "journal.jsonl")


@pytest.mark.parametrize(("schema", "said"), [(1, "which no released version wrote"), (2, "new folder"), (4, "upgrade it")])
def test_another_schema_is_named_and_refused(tmp_path: Path, schema: int, said: str) -> None:
    text = json.dumps({"schema": schema, "kind": "accuracy", "content": plain(record("a"))}).encode()
    (tmp_path / "journal.jsonl").write_bytes(hashlib.sha256(text).hexdigest()[:16].encode() + b" " + text + b"\n")
    with pytest.raises(StoreError, match=f"line 1 has schema {schema}, .*{said}"):
        read_journal(tmp_path / "journal.jsonl")
