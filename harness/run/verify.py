"""Is a run folder still what was written? Every file that the store keeps, against its checksum, its name and the journal."""

import hashlib
import io
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from plumbline.harness.findings.summary import summaries
from plumbline.harness.run.resume import merged
from plumbline.harness.store import disk, imported_scenes, zoo_record
from plumbline.harness.store.arrays import kept_hash, read_arrays
from plumbline.harness.store.journal import DamagedFile, StoreError
from plumbline.harness.store.journal_index import Index, read_index
from plumbline.harness.store.machine_fingerprint import circumstances
from plumbline.harness.store.record import Record, parts_of_runs
from plumbline.harness.store.seal import Damaged, check_seal, read_sealed
from plumbline.harness.store.store import Store, ends_early, read_plain
from plumbline.harness.store.stored_tables import COLUMNS, in_parquet

_ANEW = "--resume makes it anew"
_DELETE = "nothing needs it; delete it"
_TRUTH = re.compile(r"[0-9a-f]{16}\.npz")
_KEPT = ("study.toml", "catalogue.json", "machine.json")
_SHOWN = ("report", "recordings", imported_scenes.MINIMAL)
"""Folders that hold what people look at: made from the others alone, and not checked."""
_OF_A_NIGHT = ("night.json", "night.log", "changes")
"""What a night of a history adds; `harness.history` checks it."""


@dataclass(frozen=True, slots=True)
class Unsound:
    """A file that is not as it should be. Terms: cure: what to do."""

    path: Path
    what: str
    cure: str

    def __str__(self) -> str:
        return f"{self.path}: {self.what}; {self.cure}"


def problems(
    folder: Path, sound: Container[tuple[int, int]] = (), written: Mapping[str, str] = MappingProxyType({})
) -> Iterator[Unsound]:
    """All that is wrong with a run folder, file by file; it is only read.

    Args: sound: device and number of trajectories that are known to be what their names say, whatever folder they lie in.
    written: digests of summaries as they were written, by name, where a sealed file says them: these are not made again.
    Raises: StoreError, where it is no run folder.
    """
    store = Store(folder)
    journal = store.folder / "journal.jsonl"
    if not journal.is_file():
        yield Unsound(journal, "missing", "restore it; the tables beside it can still be read, and not be checked")
        return
    try:
        index = read_index(journal)
    except DamagedFile as error:
        yield Unsound(journal, error.what, error.cure)
        return
    if index.torn:
        yield Unsound(journal, f"its last line is torn: {index.torn} bytes", "--resume drops them and runs that trial anew")
    yield from _plain_files(store.folder, index)
    yield from _rows(store, index)
    yield from _trajectories(store.folder, index, sound)
    yield from _truths(store.folder)
    yield from _imports(store.folder)
    yield from _summaries(store, index, written)
    yield from _strangers(store.folder, index)


def _clocked(cases: Mapping[str, Any], path: Path, record: Record) -> Iterator[Unsound]:
    """A timing over anything but whole runs, by what the catalogue says that a run is."""
    case, due, timing = cases.get(record.case, {}), None, record.timing
    if timing is None:
        return
    if record.clocks in ("work", "reading") and timing.unit != "ray" and "steady" in case:
        due = max(1, round(case["duration"] / record.dt) - round((case["steady"] or 0.0) / record.dt))
    others = [sample for sample in timing.samples if timing.clocked and due not in (None, sample.run)]
    if wrong := parts_of_runs(timing) or others:
        whole = wrong[0].run if due is None else due
        what = f"trial {record.trial} was clocked over {wrong[0].steps} steps, expected whole runs of {whole}"
        yield Unsound(path, what, "its price is of a part of the motion; clock it anew in a new folder")


def _plain_files(folder: Path, index: Index) -> Iterator[Unsound]:
    documents: dict[str, Mapping[str, Any]] = {}
    for name in _KEPT:
        path = folder / name
        if not path.is_file():
            yield Unsound(path, "missing", _ANEW)
            continue
        try:
            if not check_seal(path, disk.read(path)) and index.sessions:
                raise Damaged("it has no checksum")
            documents[name] = read_plain(path)
        except Damaged as error:
            yield Unsound(path, str(error), _ANEW)
        except DamagedFile as error:
            yield Unsound(path, error.what, _ANEW)
    if early := ends_early(index, documents.get("machine.json", {})):
        yield Unsound(index.path, early, "restore it, or --resume runs their trials anew")
    if not index.sessions:
        return
    last = index.sessions[-1]
    if "study.toml" in documents and documents["study.toml"] != merged([session["study"] for session in index.sessions]):
        yield Unsound(folder / "study.toml", "is not the study of this run", _ANEW)
    if "catalogue.json" in documents and hashlib.sha256(disk.read(folder / "catalogue.json")).hexdigest() != last["catalogue"]:
        yield Unsound(folder / "catalogue.json", "is not the catalogue of this run", _ANEW)
    machine = documents.get("machine.json")
    if machine is not None:
        if circumstances(machine) != last["machine"]:
            yield Unsound(folder / "machine.json", "is not the machine of this run", _ANEW)
        if not machine.get("complete"):
            yield Unsound(folder / "machine.json", "the run did not come to its end", "--resume goes on with it")
    missing = sum(trial not in index.entries for trial in last["trials"])
    if missing:
        what = f"{missing} of {len(last['trials'])} trials have no record"
        yield Unsound(index.path, what, "--resume runs them")


def _rows(store: Store, index: Index) -> Iterator[Unsound]:
    """The tables beside the journal's records, and what each of these was clocked over."""
    try:
        cases: Mapping[str, Any] = store.catalogue.get("cases", {})
    except StoreError:  # named already
        cases = {}
    clocked: list[Unsound] = []

    def looked_at(record: Record) -> Record:
        clocked.extend(_clocked(cases, index.path, record))
        return record

    try:
        known = read_plain(store.folder / "machine.json").get("tables", {})
    except StoreError:
        known = {}
    for name, due in in_parquet(map(looked_at, index.records())).items():
        path = store.folder / f"{name}.parquet"
        if not path.is_file():
            yield Unsound(path, "missing", _ANEW)
            continue
        content = disk.read(path)
        # Another version of Parquet's library writes other bytes: then the file has to be the one that was written.
        as_written = known.get(name, "") in ("", hashlib.sha256(content).hexdigest())
        if content != due and not (as_written and _equal(content, due)):
            yield Unsound(path, "differs from the journal", _ANEW)
    yield from clocked


def _equal(content: bytes, due: bytes) -> bool:
    """Do two files hold the same table, but for columns that an older version did not write?"""
    try:
        stored, today = pd.read_parquet(io.BytesIO(content)), pd.read_parquet(io.BytesIO(due))
    except Exception:  # damage may break the reader anywhere
        return False
    names = [name for name in today.columns if name in stored.columns]
    return set(stored.columns) <= set(today.columns) and bool(stored[names].equals(today[names].astype(stored[names].dtypes)))


def _trajectories(folder: Path, index: Index, sound: Container[tuple[int, int]]) -> Iterator[Unsound]:
    directory = folder / "trajectories"
    named = {record.trajectory_hash for record in index.entries.values()} - {None}
    idle = {record.trajectory_hash for record in index.lost.values()}
    kept = {record.trajectory_hash for record in index.entries.values() if record.trajectory_kept} - {None}
    for name in sorted(str(entry) for entry in kept):
        if not (directory / f"{name}.npz").is_file():
            yield Unsound(directory / f"{name}.npz", "missing", _ANEW)
    for path in sorted(directory.glob("*")):
        if path.suffix != ".npz" or path.stem not in named | idle or not path.is_file():
            yield Unsound(path, "belongs to no trial", _DELETE)
            continue
        if (path.stat().st_dev, path.stat().st_ino) in sound:
            continue
        try:
            read_sealed(path)
            if kept_hash(read_arrays(path)) != path.stem:
                raise Damaged("its answer is not the one that its name says")
        except (Damaged, KeyError) as error:
            yield Unsound(path, str(error), _ANEW)


def _truths(folder: Path) -> Iterator[Unsound]:
    for path in sorted((folder / "truths").glob("*")):
        if not _TRUTH.fullmatch(path.name):
            yield Unsound(path, "is no truth", _DELETE)
            continue
        try:
            read_sealed(path)
        except (Damaged, OSError) as error:
            yield Unsound(
                path,
                getattr(error, "strerror", None) or str(error),
                "--resume removes it, and it is made again when it is wanted",
            )


def _imports(folder: Path) -> Iterator[Unsound]:
    for path, what in imported_scenes.unsound(folder):
        yield Unsound(path, what, imported_scenes.CURE)
    for path, what in zoo_record.unsound(folder):
        yield Unsound(path, what, zoo_record.CURE)


def _summaries(store: Store, index: Index, written: Mapping[str, str]) -> Iterator[Unsound]:
    as_written = (path.is_file() and disk.digest(path) == due for name, due in written.items() if (path := store.folder / name))
    if not index.sessions or (written and all(as_written)):
        return
    try:
        due = summaries(store)
    except StoreError:  # of the catalogue, which is named already
        return
    for name, content in due.items():
        path = store.folder / name
        if not path.is_file():
            yield Unsound(path, "missing", _ANEW)
        elif disk.read(path) != content:
            yield Unsound(path, "differs from the journal", _ANEW)


def _strangers(folder: Path, index: Index) -> Iterator[Unsound]:
    known = {"journal.jsonl", *_KEPT, "junit.xml", "summary.md", *(f"{name}.parquet" for name in COLUMNS)}
    known |= {*_SHOWN, *_OF_A_NIGHT, imported_scenes.FOLDER, zoo_record.FOLDER, "trajectories", "truths", "logs"}
    trials = {*index.entries, *index.lost, *(trial for session in index.sessions for trial in session["trials"])}
    logs = (path for path in (folder / "logs").glob("*") if path.suffix != ".log" or path.stem not in trials)
    drafts = (folder / "recordings").glob(".*")
    for path in sorted({*(path for path in folder.iterdir() if path.name not in known), *logs, *drafts}):
        yield Unsound(path, "is not of this run", _DELETE)
