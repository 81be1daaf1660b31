"""A night's work in blocks, one for each experiment and case, and what earlier nights say of each: cost, trouble, last seen."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

from plumbline.harness.history.folder import Night
from plumbline.harness.store.record import digest
from plumbline.harness.study.trial import Trial

Key: TypeAlias = tuple[str, str]
"""Experiment and case."""


Cell: TypeAlias = tuple[str, str, str, str]
"""Experiment, case, engine and track."""


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
        that were told of it. done: was all of it carried out?
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

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Sight":
        """Read back what a night wrote; fields of a later program are left aside."""
        known = {field.name for field in fields(cls)}
        return cls(**{name: value for name, value in plain.items() if name in known})


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What all earlier nights say of a block.

    Terms:
        night: the last one that did all of it. sight: what that did. of_all [s]: wall time of computing every answer, None
        where no night that is kept computed any. troubled: was it worse, or were most of its timings unstable, lately?
    """

    night: Night
    sight: Sight
    of_all: float | None
    troubled: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Unanswered:
    """A trial without an answer when a night's time was up, as its `night.json` has it. Terms: seconds: since it was asked."""

    trial: str
    experiment: str
    case: str
    engine: str
    track: str
    seconds: float

    @property
    def cell(self) -> Cell:
        """Where it belongs, whatever it rests on."""
        return self.experiment, self.case, self.engine, self.track


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
    for age, night in enumerate(reversed(nights)):
        for row in night.plan.get("blocks", ()):
            sight = Sight.from_plain(row)
            key = (sight.experiment, sight.case)
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
    return seen


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
