"""What of a history may go: old nights, answers that no night asks for any more, trajectories that none keeps."""

import shutil
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from plumbline.harness.history.answer_store import Pool
from plumbline.harness.history.blocks import last_to_see
from plumbline.harness.history.budget import bytes_of
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.readings import of_others
from plumbline.harness.store import disk
from plumbline.harness.store.journal import read_journal


@dataclass(frozen=True, slots=True)
class Pruning:
    """What goes.

    Terms: nights; answers, trajectories: files of the pool. readings: of nights that are gone or go. standing: old nights that
    stay, since each is the last that saw something. bytes: what is freed. links:
    what would go, but lies elsewhere by a link.
    """

    nights: tuple[Night, ...]
    answers: tuple[Path, ...]
    trajectories: tuple[Path, ...]
    readings: tuple[Path, ...]
    standing: tuple[Night, ...]
    bytes: int
    links: tuple[Path, ...] = ()


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
    answers, trajectories = _unnamed(history, [night for night in nights if night not in going])
    readings = of_others(history, {night.stamp for night in nights if night not in going})
    elsewhere = {
        path for path in (*(night.folder for night in going), *answers, *trajectories, *readings) if not _within(path, history)
    }
    going = tuple(night for night in going if night.folder not in elsewhere)
    answers, trajectories, readings = (
        tuple(path for path in paths if path not in elsewhere) for paths in (answers, trajectories, readings)
    )
    paths = [*(night.folder for night in going), *answers, *trajectories, *readings]
    standing = tuple(night for night in old if night in needed)
    return Pruning(going, answers, trajectories, readings, standing, bytes_of(paths, shared=False), tuple(sorted(elsewhere)))


def _within(path: Path, history: History) -> bool:
    """Does it lie where its name says, and not elsewhere by a link of it or of a folder above it?"""
    return path.resolve() == history.root.resolve() / path.relative_to(history.root)


def prune(what: Pruning) -> None:
    """Take it away: a night loses what makes it one first, so that none is ever half there. Raises: OSError."""
    for night in what.nights:
        disk.remove(night.folder / "journal.jsonl")
        shutil.rmtree(night.folder)
    for path in (*what.answers, *what.trajectories, *what.readings):
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
