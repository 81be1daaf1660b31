"""A night's work in blocks, one for each experiment and case: what earlier nights say of each (cost, trouble, last seen), in
which order the night goes through them, and which its budget leaves out.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, fields, replace
from functools import cache
from pathlib import Path
from statistics import mean
from typing import Any, Literal, TypeAlias

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
class NightSight:
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
    sight: NightSight
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


def sights_of(night: Night) -> list[NightSight]:
    """What a night did, block by block. Raises: DamagedFile."""
    known = {each.name for each in fields(NightSight)}  # those of a later program are left aside
    rows = night.plan.get("blocks", ())
    return [NightSight(**{name: value for name, value in row.items() if name in known}) for row in rows]


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


Left: TypeAlias = Callable[[], float]
"""Seconds that are left, infinite without a budget."""
LARGEST, LONGEST = 12, 120.0
"""Blocks of a batch, and seconds that they are foreseen to take: a batch is clocked before the next one is answered."""

KNOWN_SECONDS = 10.0
"""Of foreseen work, from which on it says how slow a night is: below, the start of a process counts for too much."""

Why = Literal["no time was left", "it is foreseen to take longer than was left", "time was up half-way"]
"""Why a block was left out."""


def rank(block: Block, seen: Mapping[Key, Seen], stuck: Mapping[Key, str]) -> tuple[int, str]:
    """What changed, what was worse or noisy lately, what was seen, what never was, and where nights came to their end without
    an answer: 0 to 4, with the night from which on it waits. Args: stuck: such blocks, with the last such night."""
    known = seen.get(block.key)
    if block.key in stuck:
        return 4, stuck[block.key]
    if known is None:
        return 3, ""
    changed = known.sight.digest != block.digest
    return 0 if changed else 1 if known.troubled else 2, known.night.stamp


@dataclass(slots=True)
class Plan:
    """What is left to do, and how long that will take.

    What changed goes first. Then what was troubled, what was seen and what never was share the time in equal parts, as long as
    there is some of each: so the rest is seen beside what is only noisy, a night sees something twice, and comes to the end of
    its study. Each is in the order in which it has waited.

    Terms:
        blocks: of the night. seen: by earlier nights. due: by block, the share of its answers that have to be computed.
        stuck: blocks that have a batch of their own, since they may not come to an end. taken [s]: by block, what it took
        tonight. promised [s]: by block, what it was foreseen to take when it was begun, where an earlier night knew.
        waiting: what is not begun.
    """

    blocks: InitVar[Iterable[Block]]
    seen: Mapping[Key, Seen]
    due: Mapping[Key, float]
    stuck: Mapping[Key, str] = field(default_factory=dict)
    taken: dict[Key, float] = field(default_factory=dict)
    promised: dict[Key, float] = field(default_factory=dict)
    waiting: list[Block] = field(init=False)

    def __post_init__(self, blocks: Iterable[Block]) -> None:
        self.waiting = sorted(blocks, key=lambda block: rank(block, self.seen, self.stuck))

    @property
    def slow(self) -> float:
        """Times as long as earlier nights foresaw, over all that is done; 1 at least, and as long as too little is known."""
        done = [(seconds, self.taken[key]) for key, seconds in self.promised.items() if key in self.taken]
        foreseen, taken = sum(row[0] for row in done), sum(row[1] for row in done)
        return max(1.0, taken / foreseen) if foreseen >= KNOWN_SECONDS else 1.0

    def foreseen(self, block: Block) -> float | None:
        """Seconds: by what it took in earlier nights, else by what others of its experiment took tonight; None if unknown."""
        known = self.seen.get(block.key)
        if known is not None and (known.of_all is not None or self.due[block.key] == 0.0):
            return self.due[block.key] * (known.of_all or 0.0) + known.sight.clock_seconds
        alike = [seconds for (experiment, _), seconds in self.taken.items() if experiment == block.experiment]
        return mean(alike) if alike else None

    def batches(self, left: Left) -> Iterator[list[Block]]:
        """Blocks that fit into what is left, batch by batch; what does not stays behind in `waiting`."""
        kind = {block.key: rank(block, self.seen, self.stuck)[0] for block in self.waiting}
        spent, skipped = [0.0] * 5, list[Block]()
        while self.waiting:
            batch, seconds, unknown = list[Block](), 0.0, set[str]()
            while self.waiting and len(batch) < LARGEST and seconds < LONGEST:
                block = min(self.waiting, key=lambda each: (kind[each.key] == 4, spent[kind[each.key]]))
                foreseen = self.foreseen(block)
                if batch and {block.key, batch[-1].key} & {*self.stuck}:
                    break
                if (foreseen is None and block.experiment in unknown) or (batch and (foreseen is None) != bool(unknown)):
                    break  # what one block of an experiment takes is learnt before others are begun, and keeps none waiting
                self.waiting.remove(block)
                if seconds + (foreseen or 0.0) >= left():
                    skipped.append(block)
                    continue
                if foreseen is None:
                    unknown.add(block.experiment)
                elif block.key in self.seen:
                    self.promised[block.key] = foreseen
                batch.append(block)
                seconds += foreseen or 0.0
                spent[kind[block.key]] += (foreseen or 0.0) if kind[block.key] else 0.0
            if not batch:
                break
            yield batch
            if unknown:
                for block in batch:
                    spent[kind[block.key]] += self.taken.get(block.key, 0.0)
        self.waiting = skipped + self.waiting

    def left_out(self, block: Block, why: Why) -> dict[str, Any]:
        """A block of these as a row: 'last_seen' is the stamp of a night, '' for none, 'foreseen' [s], None if unknown."""
        known = self.seen.get(block.key)
        last = "" if known is None else known.night.stamp
        about = {"experiment": block.experiment, "case": block.case, "trials": len(block.trials)}
        return about | {"why": why, "last_seen": last, "foreseen": self.foreseen(block)}
