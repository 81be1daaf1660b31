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
