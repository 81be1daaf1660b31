"""Run folders of one study's parts made into one: the same rules as within one folder, and conflicts by name.

An answer that two folders hold has to be the same in both, hash and outcome: a trial's name covers all that decides it. A trial
is clocked once, and what one machine clocked of a question is not mixed with what another one did.
"""

import hashlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import tomli_w

from plumbline.harness.run.resume import another_study, merged
from plumbline.harness.store import disk
from plumbline.harness.store.journal import FolderTaken, Writer
from plumbline.harness.store.journal_index import Entry, Index, read_index
from plumbline.harness.store.machine_fingerprint import circumstances
from plumbline.harness.store.record import Record, Timing
from plumbline.harness.store.seal import sealed_json, sealed_toml
from plumbline.harness.store.store import Store, read_plain, write_json
from plumbline.harness.store.stored_tables import write_tables

_CARRIED = ("trajectories", "truths", "scenes", "logs")
_TIMED = tuple(field.name for field in fields(Timing) if field.name not in ("trial", "note"))


def conflicts(folders: Sequence[Path]) -> list[str]:
    """In sentences, the trials that two folders answer differently. Raises: StoreError."""
    known: dict[str, tuple[Path, Entry]] = {}
    sentences = []
    for index in _read(folders):
        folder = index.path.parent
        for name, entry in index.entries.items():
            where, other = known.setdefault(name, (folder, entry))
            if (other.answer, other.status) != (entry.answer, entry.status):
                case, track, engine = entry.order[2], *entry.order[5:7]
                sentences.append(
                    f"trial {name} ({case} on {engine}/{track}): {other.status} {other.trajectory_hash} "
                    f"in {where}, {entry.status} {entry.trajectory_hash} in {folder}"
                )
    return sentences


def _read(folders: Sequence[Path]) -> Iterator[Index]:
    return (read_index(Store(folder).folder / "journal.jsonl") for folder in folders)


def merge_folders(folders: Sequence[Path], out: Path) -> tuple[Store, list[str]]:
    """The folder of all of these, which have no conflict, and what there is to say of it.

    Raises: FolderTaken, where `out` holds a run already, or one folder is of another study. StoreError, OSError.
    """
    if (out / "journal.jsonl").exists():
        raise FolderTaken(f"{out}: holds a run already; choose another --out")
    sides = list(_read(folders))
    entries = (entry for index in reversed(sides) for entry in index.entries.values())
    machines = {entry.question: entry.machine for entry in entries if entry.machine is not None}
    disk.make_folder(out)
    journal = Writer(Index(out / "journal.jsonl"), waits=False)
    notes: Counter[str] = Counter()
    try:
        for index in sides:
            for session in index.sessions:
                if other := another_study(journal.written, session["study"]):
                    raise FolderTaken(f"{index.path.parent}: is of another study than those before it, which hold {other}")
                journal.begin(session)
            _carry(index.path.parent, out)
            for record in index.records():
                if not journal.written.holds(record.trial):
                    journal.append(_unclocked(record))
                if (machine := index.clocked_on(record.trial)) is None:
                    continue
                if machines[index.entries[record.trial].question] != machine:
                    notes[f"{index.path.parent}: leaves out {{}} timings: another machine clocked the same question"] += 1
                elif journal.written.clocked_on(record.trial) is None:
                    timed = {name: getattr(record, name) for name in _TIMED}
                    journal.append(Timing(trial=record.trial, note=record.timing_note, **timed))
        _describe(sides, journal, out)
        complete = all(read_plain(folder / "machine.json").get("complete", False) for folder in folders)
        machine_of_last = read_plain(folders[-1] / "machine.json")
    finally:
        journal.close()
    ended = {"complete": complete, "journal": journal.written.reached, "tables": write_tables(out, journal.written.records())}
    write_json(out / "machine.json", machine_of_last | ended)
    return Store(out), [sentence.format(count) for sentence, count in notes.items()]


def _unclocked(record: Record) -> Record:
    """The record as its accuracy run left it."""
    blank = Timing(trial=record.trial)
    notice = f"timing: {record.timing_note}"
    warnings = record.warnings
    if record.timing_note and warnings and warnings[-1].text == notice:
        warnings = warnings[:-1]
    return replace(record, warnings=warnings, timing_note="", **{name: getattr(blank, name) for name in _TIMED})


def _carry(folder: Path, out: Path) -> None:
    """Copy the files that a folder has beside its journal, where they are not there yet. Raises: OSError."""
    for path in (path for name in _CARRIED for path in sorted((folder / name).rglob("*")) if path.is_file()):
        place = out / path.relative_to(folder)
        if not place.exists():
            for missing in (parent for parent in reversed(place.parents) if not parent.exists()):
                disk.make_folder(missing)
            disk.write_atomically(place, disk.read(path))


def _describe(sides: Sequence[Index], journal: Writer[Index], out: Path) -> None:
    """Study and catalogue of all, and a session that says what the whole is made of. Raises: StoreError, OSError."""
    catalogue: dict[str, dict[str, Any]] = {"cases": {}, "engines": {}}
    for index in sides:
        kept = read_plain(index.path.parent / "catalogue.json")
        catalogue = {kind: rows | kept.get(kind, {}) for kind, rows in catalogue.items()}
    content = sealed_json("catalogue.json", catalogue)
    disk.write_atomically(out / "catalogue.json", content)
    sessions = [session for index in sides for session in index.sessions]
    whole = {
        **sessions[-1],
        "machine": circumstances(read_plain(sides[-1].path.parent / "machine.json")),
        "catalogue": hashlib.sha256(content).hexdigest(),
        "trials": sorted({trial for session in sessions for trial in session["trials"]}),
        "engines": _joined(sessions, "engines"),
        "files": _joined(sessions, "files"),
    }
    journal.begin(whole)
    disk.write_atomically(out / "study.toml", sealed_toml("study.toml", tomli_w.dumps(merged([s["study"] for s in sessions]))))


def _joined(sessions: Sequence[Mapping[str, Any]], name: str) -> dict[str, Any]:
    return {key: value for session in sessions for key, value in session.get(name, {}).items()}
