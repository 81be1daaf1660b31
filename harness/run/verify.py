"""Is a run folder still what was written? Every file that the store keeps, against its checksum, its name and the journal."""

import hashlib
import io
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from plumbline.harness.findings.summary import summaries
from plumbline.harness.run.resume import merged
from plumbline.harness.store import disk
from plumbline.harness.store.arrays import read_arrays
from plumbline.harness.store.imported_scenes import FOLDER as SCENES
from plumbline.harness.store.imported_scenes import MINIMAL, unsound
from plumbline.harness.store.journal import DamagedFile, StoreError, Written, read_written
from plumbline.harness.store.machine_fingerprint import circumstances
from plumbline.harness.store.record import parts_of_runs
from plumbline.harness.store.seal import Damaged, check_seal, require_seal
from plumbline.harness.store.store import TABLES, Store, ends_early, parquet, read_plain, tables_of
from plumbline.harness.store.trajectory_file import kept_hash

_ANEW = "--resume makes it anew"
_DELETE = "nothing needs it; delete it"
_TRUTH = re.compile(r"[0-9a-f]{16}\.(npz|json)")
_KEPT = ("study.toml", "catalogue.json", "machine.json")
_SHOWN = ("report", "recordings", MINIMAL)
"""Folders that hold what people look at: made from the others alone, and not checked."""
_OF_A_NIGHT = ("night.json", "night.log", "changes")
"""What a night of a history adds; `harness.history` checks it."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A file that is not as it should be. Terms: cure: what to do."""

    path: Path
    what: str
    cure: str

    def __str__(self) -> str:
        return f"{self.path}: {self.what}; {self.cure}"


def problems(folder: Path, sound: Container[tuple[int, int]] = ()) -> Iterator[Problem]:
    """All that is wrong with a run folder, file by file; it is only read.

    Args: sound: device and number of trajectories that are known to be what their names say, whatever folder they lie in.
    Raises: StoreError, where it is no run folder.
    """
    store = Store(folder)
    journal = store.folder / "journal.jsonl"
    if not journal.is_file():
        yield Problem(journal, "missing", "restore it; the tables beside it can still be read, and not be checked")
        return
    try:
        written = read_written(journal)
    except DamagedFile as error:
        yield Problem(journal, error.what, error.cure)
        return
    if written.torn:
        yield Problem(journal, f"its last line is torn: {written.torn} bytes", "--resume drops them and runs that trial anew")
    yield from _plain_files(store.folder, written)
    yield from _tables(store.folder, written)
    yield from _clocked(store, written)
    yield from _trajectories(store.folder, written, sound)
    yield from _truths(store.folder)
    yield from _imports(store.folder)
    yield from _summaries(store, written)
    yield from _strangers(store.folder, written)


def notices(folder: Path) -> Iterator[str]:
    """What is worth knowing of a run folder and is not wrong."""
    try:
        records = read_written(folder / "journal.jsonl").records.values()
    except (StoreError, OSError):  # a problem, and told as one
        return
    if older := sum(bool(record.samples) and not record.clocked for record in records):
        yield f"{folder}: {older} timings of an older version, which do not say whether they are of whole runs"


def _clocked(store: Store, written: Written) -> Iterator[Problem]:
    """Timings over anything but whole runs, by what the catalogue says that a run is."""
    try:
        cases: Mapping[str, Any] = store.catalogue.get("cases", {})
    except StoreError:  # named already
        cases = {}
    for record in written.records.values():
        case, due = cases.get(record.case, {}), None
        if record.clocks in ("work", "reading") and record.unit != "ray" and "steady" in case:
            due = max(1, round(case["duration"] / record.dt) - round((case["steady"] or 0.0) / record.dt))
        others = [sample for sample in record.samples if record.clocked and due not in (None, sample.run)]
        if wrong := parts_of_runs(record.clocked, record.samples) or others:
            whole = wrong[0].run if due is None else due
            what = f"trial {record.trial} was clocked over {wrong[0].steps} steps, expected whole runs of {whole}"
            yield Problem(written.path, what, "its price is of a part of the motion; clock it anew in a new folder")


def _plain_files(folder: Path, written: Written) -> Iterator[Problem]:
    documents: dict[str, Mapping[str, Any]] = {}
    for name in _KEPT:
        path = folder / name
        if not path.is_file():
            yield Problem(path, "missing", _ANEW)
            continue
        try:
            if not check_seal(path, disk.read(path)) and written.sessions:
                raise Damaged("it has no checksum")
            documents[name] = read_plain(path)
        except Damaged as error:
            yield Problem(path, str(error), _ANEW)
        except DamagedFile as error:
            yield Problem(path, error.what, _ANEW)
    if early := ends_early(written, documents.get("machine.json", {})):
        yield Problem(written.path, early, "restore it, or --resume runs their trials anew")
    if not written.sessions:
        return
    last = written.sessions[-1]
    if "study.toml" in documents and documents["study.toml"] != merged([session["study"] for session in written.sessions]):
        yield Problem(folder / "study.toml", "is not the study of this run", _ANEW)
    if "catalogue.json" in documents and hashlib.sha256(disk.read(folder / "catalogue.json")).hexdigest() != last["catalogue"]:
        yield Problem(folder / "catalogue.json", "is not the catalogue of this run", _ANEW)
    machine = documents.get("machine.json")
    if machine is not None:
        if circumstances(machine) != last["machine"]:
            yield Problem(folder / "machine.json", "is not the machine of this run", _ANEW)
        if not machine.get("complete"):
            yield Problem(folder / "machine.json", "the run did not come to its end", "--resume goes on with it")
    missing = sum(trial not in written.records for trial in last["trials"])
    if missing:
        what = f"{missing} of {len(last['trials'])} trials have no record"
        yield Problem(written.path, what, "--resume runs them")


def _tables(folder: Path, written: Written) -> Iterator[Problem]:
    try:
        known = read_plain(folder / "machine.json").get("tables", {})
    except StoreError:
        known = {}
    for name, frame in tables_of(written.records).items():
        path = folder / f"{name}.parquet"
        if not path.is_file():
            yield Problem(path, "missing", _ANEW)
            continue
        content = disk.read(path)
        # Another version of Parquet's library writes other bytes: then the file has to be the one that was written.
        same = content == parquet(frame) or (
            known.get(name, "") in ("", hashlib.sha256(content).hexdigest()) and _equal(content, frame)
        )
        if not same:
            yield Problem(path, "differs from the journal", _ANEW)


def _equal(content: bytes, frame: pd.DataFrame) -> bool:
    try:
        kept = pd.read_parquet(io.BytesIO(content))
    except Exception:  # damage may break the reader anywhere
        return False
    names = [name for name in frame.columns if name in kept.columns]
    return set(kept.columns) <= set(frame.columns) and bool(kept[names].equals(frame[names].astype(kept[names].dtypes)))


def _trajectories(folder: Path, written: Written, sound: Container[tuple[int, int]]) -> Iterator[Problem]:
    directory = folder / "trajectories"
    named = {record.trajectory_hash for record in written.records.values()} - {None}
    idle = {record.trajectory_hash for record in written.lost.values()}
    kept = {record.trajectory_hash for record in written.records.values() if record.trajectory_kept} - {None}
    for name in sorted(str(entry) for entry in kept):
        if not (directory / f"{name}.npz").is_file():
            yield Problem(directory / f"{name}.npz", "missing", _ANEW)
    for path in sorted(directory.glob("*")):
        if path.suffix != ".npz" or path.stem not in named | idle or not path.is_file():
            yield Problem(path, "belongs to no trial", _DELETE)
            continue
        if (path.stat().st_dev, path.stat().st_ino) in sound:
            continue
        try:
            require_seal(path, disk.read(path))
            if kept_hash(read_arrays(path)) != path.stem:
                raise Damaged("its answer is not the one that its name says")
        except (Damaged, KeyError) as error:
            yield Problem(path, str(error), _ANEW)


def _truths(folder: Path) -> Iterator[Problem]:
    for path in sorted((folder / "truths").glob("*")):
        if not _TRUTH.fullmatch(path.name):
            yield Problem(path, "is no truth", _DELETE)
            continue
        try:
            require_seal(path, disk.read(path))
        except Damaged as error:
            yield Problem(path, str(error), "--resume removes it, and it is made again when it is wanted")


def _imports(folder: Path) -> Iterator[Problem]:
    for path, what in unsound(folder):
        yield Problem(path, what, "run the robot's file again into this folder with --resume")


def _summaries(store: Store, written: Written) -> Iterator[Problem]:
    if not written.sessions:
        return
    try:
        due = summaries(store)
    except StoreError:  # of the catalogue, which is named already
        return
    for name, content in due.items():
        path = store.folder / name
        if not path.is_file():
            yield Problem(path, "missing", _ANEW)
        elif disk.read(path) != content:
            yield Problem(path, "differs from the journal", _ANEW)


def _strangers(folder: Path, written: Written) -> Iterator[Problem]:
    known = {"journal.jsonl", *_KEPT, "junit.xml", "summary.md", *(f"{name}.parquet" for name in TABLES)}
    known |= {*_SHOWN, *_OF_A_NIGHT, SCENES, "trajectories", "truths", "logs"}
    trials = {*written.records, *written.lost, *(trial for session in written.sessions for trial in session["trials"])}
    logs = (path for path in (folder / "logs").glob("*") if path.suffix != ".log" or path.stem not in trials)
    drafts = (folder / "recordings").glob(".*")
    for path in sorted({*(path for path in folder.iterdir() if path.name not in known), *logs, *drafts}):
        yield Problem(path, "is not of this run", _DELETE)
