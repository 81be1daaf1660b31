"""What a history holds, whether that is still what was written, and what of it may go: old nights, answers that no night asks
for any more, trajectories that none keeps.
"""

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pandas as pd

from plumbline.harness.history.blocks import last_to_see
from plumbline.harness.history.budget import bytes_of
from plumbline.harness.history.folder import NIGHT, History, Night, Pool
from plumbline.harness.history.identity import acknowledged
from plumbline.harness.history.readings import FOLDER, of_others, versions_of
from plumbline.harness.history.sentences import outcomes_in_short
from plumbline.harness.run.verify import Unsound, problems
from plumbline.harness.store import disk
from plumbline.harness.store.arrays import kept_hash, read_arrays
from plumbline.harness.store.journal import DamagedFile, StoreError, read_journal
from plumbline.harness.store.seal import Damaged, require_seal


@dataclass(frozen=True, slots=True)
class Pruning:
    """What goes.

    Terms: nights; answers, trajectories: files of the pool. readings: of nights that are gone or go. standing: old nights that
    stay, since each is the last that saw something. links: what would go, but lies elsewhere by a link.
    """

    nights: tuple[Night, ...]
    answers: tuple[Path, ...]
    trajectories: tuple[Path, ...]
    readings: tuple[Path, ...]
    standing: tuple[Night, ...]
    links: tuple[Path, ...] = ()

    @property
    def paths(self) -> list[Path]:
        """All that goes, folders of nights first."""
        return [*(night.folder for night in self.nights), *self.answers, *self.trajectories, *self.readings]

    @property
    def bytes(self) -> int:
        """What is freed."""
        return bytes_of(self.paths, shared=False)


def pruning(history: History, *, older: float | None = None, keep_nights: int | None = None) -> Pruning:
    """What would go of a history. Args: older [s]: nights that began longer ago; keep_nights: all but the last so many.

    A night goes where both say so, or the one that is given; never one that is the last to have seen an engine in a block.
    Raises: StoreError.
    """
    nights = history.nights()
    before = None if older is None else datetime.now(UTC) - timedelta(seconds=older)
    late = nights[-keep_nights:] if keep_nights else ()
    given = older is not None or keep_nights is not None
    old = [n for n in nights if given and n not in late and (before is None or n.began < before)]
    needed = last_to_see(history.whole_nights())
    going = tuple(night for night in old if night not in needed)
    staying = [night for night in nights if night not in going]
    readings = of_others(history, {night.stamp for night in staying})
    standing = tuple(night for night in old if night in needed)
    every = Pruning(going, *_unnamed(history, staying), readings, standing)
    links = {path for path in every.paths if not _within(path, history)}
    answers, trajectories, readings = (
        tuple(path for path in paths if path not in links) for paths in (every.answers, every.trajectories, readings)
    )
    nights_here = tuple(night for night in going if night.folder not in links)
    return Pruning(nights_here, answers, trajectories, readings, standing, tuple(sorted(links)))


def _within(path: Path, history: History) -> bool:
    """Does it lie where its name says, and not elsewhere by a link of it or of a folder above it?"""
    return path.resolve() == history.root.resolve() / path.relative_to(history.root)


def prune(what: Pruning) -> None:
    """Take it away: a night loses what makes it one first, so that none is ever half there. Raises: OSError."""
    for night in what.nights:
        disk.remove(night.folder / "journal.jsonl")
        shutil.rmtree(night.folder)
    for path in what.paths[len(what.nights) :]:
        disk.remove(path)


def _unnamed(history: History, nights: list[Night]) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Answers and trajectories of the pool that no record of these nights names."""
    trials, hashes = set[str](), set[str | None]()
    for night in nights:
        for record in read_journal(night.folder / "journal.jsonl").values():
            trials.add(record.trial)
            hashes |= {record.trajectory_hash} if record.trajectory_kept else set()
    pool = Pool(history.pool)
    answers = (path for path in pool.answers() if path.stem not in trials)
    return tuple(answers), tuple(path for path in pool.trajectories() if path.stem not in hashes)


COLUMNS = (
    "night", "state", "machine", "versions", "answers", "recalled", "computed", "again", "disagreements", "clocked", "left_out",
    "worse", "better", "seconds", "megabytes", "outcomes",
)  # fmt: skip


def counted(trials: pd.DataFrame, disagreements: int = 0) -> dict[str, int]:
    """How many answers the table of a night has: all; computed, recalled, computed again, and otherwise then; clocked."""
    known, again = int((trials["recalled"] != "").sum()), int((trials["again"] != "").sum())
    counts = {"answers": len(trials), "computed": len(trials) - known, "recalled": known, "again": again}
    return counts | {"disagreements": disagreements, "clocked": int((trials["cpu_per_unit"] > 0).sum())}


def rows(history: History) -> tuple[list[dict[str, Any]], list[DamagedFile]]:
    """One for each night, the earliest first, with COLUMNS; and what is left out. Raises: StoreError."""
    each = [_row(night) if isinstance(night, Night) else night for night in history.each()]
    return [row for row in each if isinstance(row, dict)], [error for error in each if isinstance(error, DamagedFile)]


def _row(night: Night) -> dict[str, Any]:
    plan, store = night.plan, night.store()
    changes = plan.get("told", ())
    # What a night does not say that is under way, or of an older version, is read off its records.
    counts = plan if "clocked" in plan else counted(store.trials)
    versions = plan["versions"] if "versions" in plan else versions_of(store)
    return {
        "night": night.stamp,
        "state": "whole" if plan.get("complete") else "unfinished",
        "machine": f"{store.machine.get('processor', '')} x{store.machine.get('cores', '?')}",
        "versions": ", ".join(f"{engine} {version}" for engine, version in sorted(versions.items())),
        **{name: counts[name] for name in ("answers", "recalled", "computed", "again", "disagreements", "clocked")},
        "left_out": len(plan.get("left_out", ())),
        "worse": sum(row["regression"] for row in changes),
        "better": sum(row["sense"] == "better" for row in changes),
        "seconds": plan.get("seconds", {}).get("whole"),
        "megabytes": bytes_of([night.folder], shared=False) / 2**20,
        "outcomes": outcomes_in_short(plan).removeprefix("outcomes: "),
    }


_AGAIN = "delete it; the next night computes it again"
_KNOWN = ("history.json", "lock", "nights", "pool", "acknowledged.jsonl", FOLDER, "report")


def problems_of(history: History) -> Iterator[Unsound]:
    """All that is wrong with a history, file by file; it is only read. Raises: StoreError."""
    yield from _sealed(history.root / "history.json", "restore it")
    for error in (*acknowledged(history)[1], *history.unread()):
        yield Unsound(error.path, error.what, error.cure)
    sound = set[tuple[int, int]]()
    yield from _pool(Pool(history.pool), sound)
    for night in history.nights():
        path = night.folder / NIGHT
        yield from _sealed(path, "restore it, or delete the night")
        if not night.whole:
            yield Unsound(path, "the night did not come to its end", "the next call goes on with it where it asks the same")
        yield from problems(night.folder, sound, night.plan.get("summaries", {}))
    for path in sorted(history.root.glob("*")):
        if path.name not in _KNOWN:
            yield Unsound(path, "is not of this history", "nothing needs it; delete it")


def _sealed(path: Path, cure: str) -> Iterator[Unsound]:
    try:
        if not path.is_file():
            yield Unsound(path, "missing", cure)
        else:
            require_seal(path, disk.read(path))
    except Damaged as error:
        yield Unsound(path, str(error), cure)


def _pool(pool: Pool, sound: set[tuple[int, int]]) -> Iterator[Unsound]:
    """Args: sound: takes in the trajectories that are; a night's own are mostly the same files under other names."""
    for path in pool.answers():
        yield from _sealed(path, _AGAIN)
        try:
            answer = pool.answer(path.stem)
        except (StoreError, ValueError, KeyError, TypeError, json.JSONDecodeError):
            continue  # its seal said so
        if answer is None or answer.trial != path.stem:
            yield Unsound(path, "is the answer to another trial than its name says", _AGAIN)
    for path in pool.trajectories():
        try:
            require_seal(path, disk.read(path))
            if kept_hash(read_arrays(path)) != path.stem:
                raise Damaged("its answer is not the one that its name says")
            sound.add((path.stat().st_dev, path.stat().st_ino))
        except (Damaged, KeyError) as error:
            yield Unsound(path, str(error), "delete it; its hash is kept in the journals")
