"""What the commands on a history cost as nights come: `python -m tests.long_history [NIGHTS] [--keep DIR]`.

Two nights are carried out in this process, and the second is written again for each day, its prices with noise of its own; all
nights share their trajectories with the pool, as nights do. Printed are CPU seconds and peak memory [MB] of each command.
"""

import argparse
import os
import shutil
import tempfile
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.findings.summary import SUMMARIES, write_summary
from plumbline.harness.history.folder import NIGHT, Night, created, stamp_of
from plumbline.harness.history.readings import FOLDER
from plumbline.harness.store import disk
from plumbline.harness.store.journal import Writer, Written, read_written
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import read_plain, write_json
from plumbline.harness.store.stored_tables import in_order, write_tables
from tests.growth import measured
from tests.nights import night, planted

NIGHTS = 1000
FIRST = datetime(2024, 1, 1, 1, 30, tzinfo=UTC)
SLOW, NOISE = 0.05, 0.02
"""Of the logarithms of prices: what a night does to all of them, and what each has of its own."""


def write_nights(root: Path, nights: int) -> None:
    """A history of so many nights, all but the last copies of one, each with prices of its own."""
    for _ in range(2):
        with planted():
            night(root)
    history = created(root)
    first, model = history.nights()
    shutil.rmtree(first.folder)
    rng = np.random.default_rng(11)
    for number in range(nights - 1):
        _copied(model, history.night(stamp_of(FIRST + timedelta(days=number))), rng)


def _copied(model: Night, other: Night, rng: np.random.Generator) -> None:
    """The night again, under another name."""
    other.folder.mkdir()
    written = read_written(model.folder / "journal.jsonl")
    slow = rng.normal(0, SLOW)
    journal = Writer(Written(other.folder / "journal.jsonl"), waits=False)
    journal.begin(written.sessions[0])
    for record in written.records.values():
        journal.append(_times(record, float(np.exp(slow + rng.normal(0, NOISE))), float(np.exp(slow))))
    for session in written.sessions[1:]:
        journal.begin(session)
    journal.close()
    for name in ("catalogue.json", "study.toml"):
        shutil.copy(model.folder / name, other.folder / name)
    machine = read_plain(model.folder / "machine.json") | {"journal": journal.written.reached}
    tables = write_tables(other.folder, in_order(journal.written.records.values()))
    write_json(other.folder / "machine.json", machine | {"tables": tables})
    (other.folder / "trajectories").mkdir()
    for path in (model.folder / "trajectories").iterdir():
        os.link(path, other.folder / "trajectories" / path.name)
    write_summary(other.store())
    summaries = {name: disk.digest(other.folder / name) for name in SUMMARIES}
    write_json(other.folder / NIGHT, dict(model.plan) | {"stamp": other.stamp, "summaries": summaries})


def _times(record: Record, factor: float, slow: float) -> Record:
    """The record, so many times as dear on a machine that is so much slower."""
    if record.timing is None or record.timing.cpu_per_unit is None:
        return record
    scaled: dict[str, Any] = {
        name: factor * float(getattr(record.timing, name)) for name in ("cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high")
    }
    samples = tuple(replace(s, cpu=factor * s.cpu, wall=factor * s.wall, canary=slow * s.canary) for s in record.timing.samples)
    return replace(record, timing=replace(record.timing, samples=samples, **scaled))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("nights", nargs="?", type=int, default=NIGHTS)
    parser.add_argument("--keep", type=Path, help="Where the history is, or stays.")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        root = given.keep or Path(scratch) / "h"
        if not root.exists():
            write_nights(root, given.nights)
        shutil.rmtree(root / FOLDER, ignore_errors=True)
        shutil.rmtree(root / "report", ignore_errors=True)
        for name, words in (
            ("verify", ["verify", str(root)]),
            ("history", ["history", str(root)]),
            ("trends, cold", ["history", "trends", str(root)]),
            ("trends, warm", ["history", "trends", str(root)]),
        ):
            seconds, memory, code = measured(words, Path(scratch) / "told.txt")
            print(f"{given.nights:>7} nights  {name:<14} {seconds:7.1f} s {memory:6.0f} MB  exit {code}", flush=True)


if __name__ == "__main__":
    main()
