"""A night's work in blocks, one for each experiment and case, and what earlier nights say of each: cost, trouble, last seen."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

from plumbline.harness.findings.changes.matching import LOST
from plumbline.harness.history.folder import Night
from plumbline.harness.store.record import digest
from plumbline.harness.study.trial import Trial

Key: TypeAlias = tuple[str, str]
"""Experiment and case."""


Cell: TypeAlias = tuple[str, str, str, str]
"""Experiment, case, engine and track; of a search for settings, the track that they descend from."""
SeenCell: TypeAlias = tuple[str, str, str, str, str]
"""A cell, and the study that asked it: the same words of another study are another question."""
Saw: TypeAlias = Mapping[str, Mapping[str, Any]]
"""By engine: its version, its tracks, how many trials it had, and how many of them had no answer, as 'version', 'tracks',
'trials' and 'lost'."""


@dataclass(frozen=True, slots=True)
class Block:
    """The trials of a case in an experiment, on all engines: what is clocked side by side."""

    experiment: str
    case: str
    trials: tuple[Trial, ...]

    @property
    def key(self) -> Key:
        """What it is called."""
        return self.experiment, self.case

    @property
    def digest(self) -> str:
        """Another one where anything changed that an answer of it rests on."""
        return digest(sorted(trial.trial for trial in self.trials))


@dataclass(slots=True, kw_only=True)
class Sight:
    """What one night did of a block, as its `night.json` keeps it; counted as the night goes on.

    Terms:
        digest: of the block. answers: with those that searches went on to. computed: of these, not recalled. answer_seconds,
        clock_seconds: wall time of both. clocked: trials. unstable: of these, those whose timing is marked so. worse: changes
        that were told of it. done: was all of it carried out? saw: which engines had it; nothing in nights of an older version.
    """

    experiment: str
    case: str
    digest: str = ""
    answers: int = 0
    computed: int = 0
    answer_seconds: float = 0.0
    clocked: int = 0
    clock_seconds: float = 0.0
    unstable: int = 0
    worse: int = 0
    done: bool = True
    saw: Saw = field(default_factory=dict)

    @property
    def key(self) -> Key:
        """Of the block."""
        return self.experiment, self.case


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What all earlier nights say of a block.

    Terms:
        night: the last one that did all of it. sight: what that did. of_all [s]: wall time of computing every answer, None
        where no night that is kept computed any. troubled: was it worse, or were most of its timings unstable, lately?
        of_engine: the last night that did all of it on an engine, where that is said.
    """

    night: Night
    sight: Sight
    of_all: float | None
    troubled: bool
    of_engine: Mapping[str, Night] = field(default_factory=dict)

    def night_of(self, engine: str) -> Night:
        """The last night that did all of it, on an engine where that is said."""
        return self.of_engine.get(engine, self.night)

    @property
    def nights(self) -> tuple[Night, ...]:
        """All that `night_of` may name."""
        return (self.night, *self.of_engine.values())


LONG = 10.0
"""Seconds without an answer from which on a trial is what a night came to its end with, and no longer a chance."""
LATELY = 3
"""Nights that a regression or noise counts for."""
NOISY = 0.5
"""Share of unstable timings from which a block is noisy."""


def blocks_of(trials: Iterable[Trial]) -> tuple[Block, ...]:
    """The blocks in the order in which a study names them."""
    grouped: dict[Key, list[Trial]] = {}
    for trial in trials:
        grouped.setdefault((trial.experiment.name, trial.case), []).append(trial)
    return tuple(Block(*key, tuple(group)) for key, group in grouped.items())


def sights_of(night: Night) -> list[Sight]:
    """What a night did, block by block. Raises: DamagedFile."""
    known = {each.name for each in fields(Sight)}  # those of a later program are left aside
    rows = night.plan.get("blocks", ())
    return [Sight(**{name: value for name, value in row.items() if name in known}) for row in rows]


def last_seen(nights: Sequence[Night]) -> dict[Key, Seen]:
    """By block. Args: nights: whole ones, the earliest first. Raises: DamagedFile."""
    seen: dict[Key, Seen] = {}
    of_engine: dict[Key, dict[str, Night]] = {}
    for age, night in enumerate(reversed(nights)):
        for sight in sights_of(night):
            last_of = of_engine.setdefault(sight.key, {})
            for engine in sight.saw if sight.done else ():
                last_of.setdefault(engine, night)
            if sight.key not in seen and not sight.done:
                continue
            known = seen.get(sight.key) or Seen(night=night, sight=sight, of_all=None, troubled=False, of_engine=last_of)
            noisy = known.sight is sight and 0 < sight.clocked < sight.unstable / NOISY
            of_all = sight.answer_seconds * sight.answers / sight.computed if sight.computed else None
            seen[sight.key] = replace(
                known,
                of_all=of_all if known.of_all is None else known.of_all,
                troubled=known.troubled or (age < LATELY and (noisy or sight.worse > 0)),
            )
    return seen


def cells_of(rows: Iterable[Any]) -> dict[Key, dict[str, dict[str, Any]]]:
    """By block what `Saw` holds. Args: rows: of the table `trials`."""
    cells: dict[Key, dict[str, dict[str, Any]]] = {}
    for row in rows:
        engines = cells.setdefault((row.experiment, row.case), {})
        saw = engines.setdefault(row.engine, {"version": str(row.engine_version), "tracks": [], "trials": 0, "lost": 0})
        saw["tracks"] = sorted({*saw["tracks"], cell_of(row)[3]})
        saw["trials"] += 1
        saw["lost"] += row.status in LOST
    return cells


def cell_of(row: Any) -> SeenCell:
    """Where a row of the table `trials` belongs."""
    return row.experiment, row.case, row.engine, str(row.track).partition(",")[0], row.study


def seen_cells(night: Night) -> dict[SeenCell, Mapping[str, Any]]:
    """The cells of the blocks that a night did all of, each with what `Saw` holds of its engine.

    What a night of an older version does not say is read off its journal. Raises: StoreError.
    """
    return {
        (*sight.key, engine, track, night.plan["study"]): of_engine
        for sight in sights_of(night)
        if sight.done
        for engine, of_engine in (sight.saw or _of_journal(night.folder).get(sight.key, {})).items()
        for track in of_engine["tracks"]
    }


@cache
def _of_journal(folder: Path) -> dict[Key, dict[str, dict[str, Any]]]:
    return cells_of(Night(folder.name, folder).store().trials.itertuples())


def last_to_see(nights: Sequence[Night]) -> set[Night]:
    """The nights that some cell was last seen in, and, where an engine lost answers in that one, the last in which it lost the
    fewest: what later nights are compared with.

    Args: nights: whole ones, the earliest first. Raises: StoreError.
    """
    last: dict[SeenCell, Night] = {}
    fewest: dict[SeenCell, tuple[int, Night]] = {}
    for night in reversed(nights):
        for cell, saw in seen_cells(night).items():
            last.setdefault(cell, night)
            if cell not in fewest or saw["lost"] < fewest[cell][0]:
                fewest[cell] = saw["lost"], night
    return {*last.values(), *(night for _, night in fewest.values())}


def last_unanswered(nights: Sequence[Night], seen: Mapping[Key, Seen]) -> dict[Cell, str]:
    """Trials for which nights have waited long and in vain, each with the stamp of the last such night.

    Args: nights: whole ones, the earliest first. seen: what was done of each block; what was done since is left out.
    Raises: DamagedFile.
    """
    known: dict[Cell, str] = {}
    for night in nights:
        for row in night.plan.get("unanswered", ()):
            cell = row["experiment"], row["case"], row["engine"], row["track"]
            done = seen.get(cell[:2])
            if row["seconds"] >= LONG and (done is None or done.night.stamp < night.stamp):
                known[cell] = night.stamp
    return known
