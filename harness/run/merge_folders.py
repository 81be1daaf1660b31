"""Run folders of one study's parts made into one: the same rules as within one folder, and conflicts by name.

An answer that two folders hold has to be the same in both, hash and outcome: a trial's name covers all that decides it. A trial
is clocked once, and what one machine clocked of a question is not mixed with what another one did.

All is read and checked first; then the whole is written beside its place, and takes its name when nothing is missing. Links are
not followed, and of several copies of a file a sound one is taken.
"""

import hashlib
import os
import re
import shutil
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import tomli_w

from plumbline.harness.run.resume import another_study, merged
from plumbline.harness.store import disk
from plumbline.harness.store.journal import FolderTaken, StoreError, Writer
from plumbline.harness.store.journal_index import Index, Whereabouts, read_index
from plumbline.harness.store.machine_fingerprint import circumstances
from plumbline.harness.store.seal import Damaged, read_sealed, sealed_json, sealed_toml
from plumbline.harness.store.store import Store, ends_early, read_plain, write_json
from plumbline.harness.store.stored_tables import write_tables

_CARRIED = re.compile(
    r"(trajectories/[0-9a-f]{16}\.npz|truths/[0-9a-f]{16}\.npz|scenes/[0-9a-f]{12}/[\w.-]+\.(toml|json)|logs/[\w-]+\.log)"
)
"""What a folder has beside its journal."""


def conflicts(folders: Sequence[Path]) -> list[str]:
    """In sentences, the trials that two folders answer differently. Raises: StoreError."""
    known: dict[str, tuple[Path, Whereabouts]] = {}
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

    Raises: FolderTaken, where `out` holds something already, or one folder is of another study. StoreError, where a folder
    cannot be read, or holds a link or a damaged file that no other one has whole; OSError. Nothing is written then.
    """
    if out.exists() and any(out.iterdir()):
        raise FolderTaken(
            f"{out}: holds {'a run' if (out / 'journal.jsonl').exists() else 'files'} already; choose another --out"
        )
    sides = list(_read(folders))
    notes = [note for index in sides for note in (*index.notes, *_cut(index))]
    _same_study(sides)
    files = _files(sides)
    draft = out.absolute().with_name(f".{out.name}.{os.getpid()}")
    disk.make_folder(draft)
    try:
        notes += _written(sides, files, draft)
        with suppress(FileNotFoundError):
            out.rmdir()
        disk.put_in_place(draft, out.absolute())
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise
    return Store(out), notes


def _cut(index: Index) -> list[str]:
    early = ends_early(index, read_plain(index.path.parent / "machine.json"))
    return [f"{index.path}: {early}"] if early else []


def _same_study(sides: Sequence[Index]) -> None:
    """Raises: StoreError, where none has begun; FolderTaken, where one is of another study."""
    before = Index(sides[0].path)
    for index in sides:
        for session in index.sessions:
            if other := another_study(before, session["study"]):
                raise FolderTaken(f"{index.path.parent}: is of another study than those before it, which hold {other}")
            before.sessions.append(session)
    if not before.sessions:
        raise StoreError(f"{sides[0].path.parent}: no run has begun in it, nor in the others; there is nothing to merge")


def _files(sides: Sequence[Index]) -> dict[str, Path]:
    """By its name in a folder, a sound copy of each file that is carried. Raises: StoreError, OSError."""
    sound: dict[str, Path] = {}
    damaged: dict[str, str] = {}
    for index in sides:
        folder = index.path.parent
        for room, rooms, names in os.walk(folder):
            for path in (Path(room, name) for name in (*rooms, *names)):
                name = path.relative_to(folder).as_posix()
                if path.is_symlink() and name.startswith(("trajectories", "truths", "scenes", "logs")):
                    raise StoreError(f"{path}: is a link, expected a file of this folder; put what it names in its place")
                if not _CARRIED.fullmatch(name) or not path.is_file() or name in sound:
                    continue
                try:
                    if path.suffix != ".log":
                        read_sealed(path)
                    sound[name] = path
                except Damaged as error:
                    damaged[name] = f"{path}: {error}; run that part again with --resume, which makes it anew"
    if lost := [why for name, why in damaged.items() if name not in sound]:
        raise StoreError(f"{len(lost)} damaged files that no other folder holds whole, first: {lost[0]}")
    return sound


def _written(sides: Sequence[Index], files: Mapping[str, Path], out: Path) -> list[str]:
    """Write all of these into a folder that is there. Returns: what was left out, in sentences. Raises: StoreError, OSError."""
    entries = (entry for index in reversed(sides) for entry in index.entries.values())
    machines = {entry.question: entry.machine for entry in entries if entry.machine is not None}
    for name, path in files.items():
        disk.make_folder((out / name).parent)
        disk.write_atomically(out / name, disk.read(path))
    notes: Counter[str] = Counter()
    journal = Writer(Index(out / "journal.jsonl"), waits=False)
    try:
        for index in sides:
            for session in index.sessions:
                journal.begin(session)
            for record in index.records():
                if record.trial not in journal.written.entries:
                    journal.append(replace(record, timing=None))
                if (machine := index.clocked_on(record.trial)) is None:
                    continue
                if machines[index.entries[record.trial].question] != machine:
                    notes[f"{index.path.parent}: leaves out {{}} timings: another machine clocked the same question"] += 1
                elif journal.written.clocked_on(record.trial) is None and record.timing is not None:
                    journal.append(record.timing)
        due = _describe(sides, journal, out)
    finally:
        journal.close()
    parts = [read_plain(index.path.parent / "machine.json") for index in sides]
    missing = sum(trial not in journal.written.entries for trial in due)
    complete = not missing and all(part.get("complete", False) for part in parts)
    ended = {"complete": complete, "journal": journal.written.reached, "tables": write_tables(out, journal.written.records())}
    write_json(out / "machine.json", parts[-1] | ended)
    left_out = [sentence.format(count) for sentence, count in notes.items()]
    return [*left_out, *([f"{missing} of {len(due)} trials have no record in any folder"] if missing else [])]


def _describe(sides: Sequence[Index], journal: Writer[Index], out: Path) -> list[str]:
    """Study and catalogue of all, and a session that says what the whole is made of. Returns: its trials. Raises: OSError."""
    catalogue: dict[str, dict[str, Any]] = {"cases": {}, "engines": {}}
    for index in sides:
        kept = read_plain(index.path.parent / "catalogue.json")
        catalogue = {kind: rows | kept.get(kind, {}) for kind, rows in catalogue.items()}
    content = sealed_json("catalogue.json", catalogue)
    disk.write_atomically(out / "catalogue.json", content)
    sessions = [session for index in sides for session in index.sessions]
    trials = sorted({trial for session in sessions for trial in session["trials"]})
    whole = {
        **sessions[-1],
        "machine": circumstances(read_plain(sides[-1].path.parent / "machine.json")),
        "catalogue": hashlib.sha256(content).hexdigest(),
        "trials": trials,
        "engines": _joined(sessions, "engines"),
        "files": _joined(sessions, "files"),
    }
    journal.begin(whole)
    disk.write_atomically(out / "study.toml", sealed_toml("study.toml", tomli_w.dumps(merged([s["study"] for s in sessions]))))
    return trials


def _joined(sessions: Sequence[Mapping[str, Any]], name: str) -> dict[str, Any]:
    return {key: value for session in sessions for key, value in session.get(name, {}).items()}
