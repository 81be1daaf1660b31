"""The journal: torn tails are dropped, corruption is named, nothing stands twice."""

import json
from pathlib import Path

import pytest

from harness.journal import Journal, StoreError, read_journal
from harness.record import Measurement, Record, Sample, Timing


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
    assert found["b"].cpu_per_sim_s == 0.5
    assert found["b"].samples == TIMING.samples


def test_a_last_line_cut_at_any_byte_is_dropped_and_the_rest_kept(tmp_path: Path) -> None:
    whole = write(tmp_path)
    last = whole.rstrip(b"\n").rfind(b"\n") + 1
    path = tmp_path / "journal.jsonl"
    for cut in range(last, len(whole)):
        path.write_bytes(whole[:cut])
        assert list(read_journal(path)) == ["a", "b", "c"]
        assert read_journal(path)["b"].cpu_per_sim_s is None
        journal = Journal(tmp_path)
        assert journal.dropped == cut - last
        assert journal.timings == {}
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
