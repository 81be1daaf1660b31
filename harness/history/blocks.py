"""A night's work in blocks, one for each experiment and case, and what earlier nights say of each: cost, trouble, last seen."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from plumbline.harness.findings.changes.matching import LOST
from plumbline.harness.history.folder import Night
from plumbline.harness.store.record import digest
from plumbline.harness.study.trial import Trial

Key: TypeAlias = tuple[str, str]
"""Experiment and case."""


Cell: TypeAlias = tuple[str, str, str, str]
"""Experiment, case, engine and track; of a search for settings, the track that they descend from."""
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

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Sight":
        """Read back what a night wrote; fields of a later program are left aside."""
        known = {each.name for each in fields(cls)}
        return cls(**{name: value for name, value in plain.items() if name in known})


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


def last_seen(nights: Sequence[Night]) -> dict[Key, Seen]:
    """By block. Args: nights: whole ones, the earliest first. Raises: DamagedFile."""
    seen: dict[Key, Seen] = {}
    of_engine: dict[Key, dict[str, Night]] = {}
    for age, night in enumerate(reversed(nights)):
        for row in night.plan.get("blocks", ()):
            sight = Sight.from_plain(row)
            key = (sight.experiment, sight.case)
            for engine in sight.saw if sight.done else ():
                of_engine.setdefault(key, {}).setdefault(engine, night)
            of_all = sight.answer_seconds * sight.answers / sight.computed if sight.computed else None
            if key not in seen:
                if sight.done:
                    noisy = sight.clocked > 0 and sight.unstable > NOISY * sight.clocked
                    troubled = age < LATELY and (noisy or sight.worse > 0)
                    seen[key] = Seen(night=night, sight=sight, of_all=of_all, troubled=troubled)
                continue
            known = seen[key]
            troubled = known.troubled or (age < LATELY and sight.worse > 0)
            least = known.of_all if known.of_all is not None else of_all
            seen[key] = Seen(night=known.night, sight=known.sight, of_all=least, troubled=troubled)
    return {key: replace(last, of_engine=of_engine.get(key, {})) for key, last in seen.items()}


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


def cell_of(row: Any) -> Cell:
    """Where a row of the table `trials` belongs."""
    return row.experiment, row.case, row.engine, str(row.track).partition(",")[0]


class Answered(NamedTuple):
    """How many trials an engine had in a block, and how many of them had no answer."""

    trials: int
    lost: int

    @property
    def mute(self) -> bool:
        """Had none of them an answer?"""
        return self.lost >= self.trials


def seen_cells(night: Night) -> dict[Cell, Answered]:
    """The cells of the blocks that a night did all of.

    What a night of an older version does not say is read off its journal. Raises: StoreError.
    """
    cells: dict[Cell, Answered] = {}
    for sight in map(Sight.from_plain, night.plan.get("blocks", ())):
        if sight.done:
            saw = sight.saw or _of_journal(night.folder).get((sight.experiment, sight.case), {})
            for engine, of_engine in saw.items():
                answered = Answered(of_engine["trials"], of_engine["lost"])
                cells |= {(sight.experiment, sight.case, engine, track): answered for track in of_engine["tracks"]}
    return cells


@cache
def _of_journal(folder: Path) -> dict[Key, dict[str, dict[str, Any]]]:
    return cells_of(Night(folder.name, folder).store().trials.itertuples())


def last_to_see(nights: Sequence[Night]) -> set[Night]:
    """The nights that some cell was last seen in, and, where an engine lost answers in that one, the last in which it lost the
    fewest: what later nights are compared with.

    Args: nights: whole ones, the earliest first. Raises: StoreError.
    """
    last: dict[Cell, Night] = {}
    fewest: dict[Cell, tuple[int, Night]] = {}
    for night in reversed(nights):
        for cell, answered in seen_cells(night).items():
            last.setdefault(cell, night)
            if cell not in fewest or answered.lost < fewest[cell][0]:
                fewest[cell] = answered.lost, night
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
