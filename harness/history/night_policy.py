"""A night's run, steered by its history: known results are reused, a random share of them is computed again.

What an engine answered to a case before a night in which it gave another answer to the same digest is not recalled any more.
"""

import math
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

from plumbline.harness.findings.changes.prices import TOLD
from plumbline.harness.history.answer_store import MACHINE_BOUND, Pool
from plumbline.harness.history.blocks import Block, Cell, Key, Seen, Sight, blocks_of
from plumbline.harness.history.known_searches import KnownSearches
from plumbline.harness.history.plan import Left, Plan
from plumbline.harness.run.interrupt import UnderWay
from plumbline.harness.run.known_results import Guide
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, StoreError
from plumbline.harness.store.record import Record, Timing, digest
from plumbline.harness.study.trial import Trial

AGAIN = 1 / 20
"""Share of the known answers that are computed again: digests do not see the C library, the processor, the compiler."""
MOST_KEPT = 2**30
"""Bytes of new trajectories that a night keeps; of what goes beyond, the hash."""
Keep: TypeAlias = Literal["all", "changed", "none"]
"""Of which answers a night keeps trajectories: 'changed' leaves out what passed as before."""


def computed_again(trial: str, seed: str) -> bool:
    """Is a known answer computed again in the night of this seed? The same of the same seed, in whatever order it is asked."""
    return int(digest([seed, trial]), 16) < AGAIN * 2**64


@dataclass(slots=True, kw_only=True)
class Steering(Guide):
    """The guide of one night.

    Terms:
        folder: of the night. stamp: its name. seed: of what is drawn. machine: the digest of this one. seen: what earlier
        nights say of each block. waited: trials for which earlier nights waited in vain, by the last of them. searched: with
        what was answered the last time. distrusted: by case and engine, the night before which nothing
        is recalled. left: seconds until the end. save: called behind each batch, and keeps what a night that goes on has to
        know. hashes: of trajectories that stay. out, unanswered: rows of `night.json`, what was left out, and what was waited
        for when time was up. sitting: 0, as a night may end after any question.
    """

    sitting = 0.0
    pool: Pool
    folder: Path
    stamp: str
    seed: str
    machine: str
    keep: Keep
    seen: Mapping[Key, Seen]
    waited: Mapping[Cell, str]
    searched: KnownSearches
    distrusted: dict[tuple[str, str], str]
    left: Left
    save: Callable[["Steering"], None]
    blocks: tuple[Block, ...] = ()
    done: set[Key] = field(default_factory=set)
    begun: set[Key] = field(default_factory=set)
    tallies: dict[Key, Sight] = field(default_factory=dict)
    out: list[dict[str, Any]] = field(default_factory=list)
    unanswered: list[dict[str, Any]] = field(default_factory=list)
    _plan: Plan | None = None
    _again: dict[str, Record] = field(default_factory=dict)
    _mark: float = 0.0
    _clocking: float = 0.0
    hashes: set[str | None] = field(default_factory=set)
    _kept: int = 0

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """Block after block, the most valuable first, as long as there is time."""
        self.blocks = blocks_of(trials)
        due = {block.key: self._due(block) for block in self.blocks}
        stuck = {cell[:2]: stamp for cell, stamp in self.waited.items()}
        self._plan = plan = Plan(self.blocks, self.seen, due, stuck)
        for batch in plan.batches(self.left):
            self._mark = time.monotonic()
            self.begun |= {block.key for block in batch}
            yield sorted((trial for block in batch for trial in block.trials), key=lambda trial: _cell(trial) in self.waited)
            self.done |= {block.key for block in batch}
            for block in batch:
                tally = self._tally(block.key)
                plan.taken[block.key] = tally.answer_seconds + tally.clock_seconds
            self.tidy()
            self.save(self)

    @property
    def slow(self) -> float:
        """Times as long as foreseen."""
        return 1.0 if self._plan is None else self._plan.slow

    def known(self, trial: Trial) -> Record | None:
        """From the pool, unless it is drawn to be computed again, depends on the machine, or is distrusted."""
        found = self._pooled(trial)
        if found is None:
            return None
        if computed_again(trial.trial, self.seed):
            self._again[trial.trial] = found
            return None
        self._tally((trial.experiment.name, trial.case)).answers += 1
        kept = found.trajectory_hash is not None and self._link(found.trajectory_hash)
        self.hashes |= {found.trajectory_hash} if kept else set()
        return replace(found, round=trial.round, trajectory_kept=kept)

    def answered(self, trial: Trial, record: Record) -> Record:
        """Keep an answer in the pool, compare it with what was known, and say whether its trajectory stays."""
        tally, now = self._tally((trial.experiment.name, trial.case)), time.monotonic()
        tally.answers += 1
        tally.computed += 1
        tally.answer_seconds, self._mark = tally.answer_seconds + now - self._mark, now
        known = self._again.pop(trial.trial, None)
        bound = known is not None and {known.status, record.status} & {*MACHINE_BOUND, "interrupted", "unavailable"}
        if known is not None and not bound:
            record = replace(record, again=known.answer)
            if record.disagrees:
                self.distrusted[record.case, record.engine] = self.stamp
        record = replace(record, trajectory_kept=record.trajectory_hash is not None and self._stays(trial, record))
        self.hashes |= {record.trajectory_hash} if record.trajectory_kept else set()
        if record.again != record.answer:
            try:
                self.pool.keep(record, self.stamp)
            except DamagedFile as error:
                print(f"{error}; the answer is kept by the night alone", file=sys.stderr)
        return record

    def beside(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> list[Trial]:
        """Where the searches of earlier nights ended."""
        del records
        return self.searched.beside(trials)

    def searches(self, trial: Trial, records: Mapping[str, Record]) -> bool:
        """Limits are searched as far as they have to; fronts where they are not known, or err otherwise now."""
        known = self._pooled(trial) is not None
        return known or not trial.experiment.sweep or self.searched.goes_on(trial, records)

    def clocks(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> Collection[str]:
        """All that is due, but of fronts what is known to be on them, with a few beside."""
        del records
        self._mark = time.monotonic()
        swept = [trial for trial in trials if trial.experiment.sweep]
        return {trial.trial for trial in trials if not trial.experiment.sweep} | self.searched.clocked(swept)

    def clocked(self, trials: Sequence[Trial]) -> None:
        """Take note of what that took."""
        tally, now = self._tally((trials[0].experiment.name, trials[0].case)), time.monotonic()
        tally.clocked += len(trials)
        self._clocking = now - self._mark
        tally.clock_seconds, self._mark = tally.clock_seconds + self._clocking, now

    def doubts(self, timings: Sequence[Timing]) -> bool:
        """Is one unstable and dearer than the last time, with time left to clock them once more?"""
        trials = {trial.trial: trial for block in self.blocks for trial in block.trials}
        for timing in timings:
            trial = trials.get(timing.trial)
            before = None if trial is None or not timing.unstable_timing else self.searched.last.of(trial)
            if before is not None and (timing.cpu_per_unit or 0.0) > (1 + TOLD) * (before.cpu_per_unit or math.inf):
                return self.left() > self._clocking
        return False

    def broken_off(self, under_way: Sequence[UnderWay]) -> None:
        """Keep what the night waited for in the end."""
        self.unanswered += [
            {"trial": waiting.trial.trial, "seconds": waiting.seconds}
            | dict(zip(("experiment", "case", "engine", "track"), _cell(waiting.trial), strict=True))
            for waiting in under_way
        ]

    def asked(self, trials: Collection[str], records: Mapping[str, Record]) -> Collection[str]:
        """What has a record: what the budget left out was not asked."""
        return [trial for trial in trials if trial in records]

    def close(self) -> None:
        """Name what was left out, and take away what is not kept. Raises: OSError."""
        if (plan := self._plan) is not None:
            self.out += [plan.left_out(b, "time was up half-way") for b in self.blocks if b.key in self.begun - self.done]
            for block in plan.waiting:
                dear = self.left() > 0.0 and plan.foreseen(block) is not None
                self.out.append(
                    plan.left_out(block, "it is foreseen to take longer than was left" if dear else "no time was left")
                )
        self.tidy()

    def go_on(self, sights: Sequence[Sight], records: Iterable[Record]) -> None:
        """Begin where a night was broken off. Args: sights: what it had saved. records: of its journal."""
        kept = [record for record in records if record.trajectory_kept]
        self.hashes |= {record.trajectory_hash for record in kept}
        new = {record.trajectory_hash for record in kept if not record.recalled and record.trajectory_hash is not None}
        self._kept = sum(self._size(each) for each in new if not self.pool.trajectory_path(each).is_file())
        self.tallies |= {sight.key: sight for sight in sights}

    def tidy(self) -> None:
        """Put the trajectories that are kept into the pool, take the others away. Raises: OSError."""
        for path in sorted((self.folder / "trajectories").glob("[!.]*.npz")):
            if path.stem in self.hashes:
                self.pool.keep_trajectory(path)
            else:
                disk.remove(path)

    def sights(self, unstable: Mapping[Key, int], worse: Mapping[Key, int]) -> list[dict[str, Any]]:
        """What was done of each block. Args: how many timings of it are unstable, how many changes for the worse it had."""
        return [
            asdict(tally)
            | {"digest": block.digest, "done": block.key in self.done}
            | {"unstable": unstable.get(block.key, 0), "worse": worse.get(block.key, 0)}
            for block in self.blocks
            if (tally := self.tallies.get(block.key)) is not None
        ]

    def _due(self, block: Block) -> float:
        """The share of a block's answers that have to be computed."""
        due = sum(not self.pool.holds(t.trial) or computed_again(t.trial, self.seed) for t in block.trials)
        return due / len(block.trials)

    def _pooled(self, trial: Trial) -> Record | None:
        try:
            found = self.pool.answer(trial.trial)
        except StoreError as error:
            print(f"{error}; its answer is computed again", file=sys.stderr)
            return None
        if found is None or (found.status in MACHINE_BOUND and found.answered_on != self.machine):
            return None
        return None if found.recalled < self.distrusted.get((trial.case, trial.engine), "") else found

    def _link(self, trajectory_hash: str) -> bool:
        """Lay a trajectory of the pool into the night: is it there?"""
        if self.keep == "none":
            return False
        path = self.folder / "trajectories" / f"{trajectory_hash}.npz"
        return path.is_file() or self.pool.lay(path)

    def _stays(self, trial: Trial, record: Record) -> bool:
        """Does a computed trajectory stay?"""
        if self.keep == "none":
            return False
        if record.trajectory_hash is not None and self.pool.trajectory_path(record.trajectory_hash).is_file():
            return True
        before = self.searched.last.of(trial)
        as_before = before is not None and (before.status, before.trajectory_hash) == ("passed", record.trajectory_hash)
        if self.keep == "changed" and record.status == "passed" and as_before:
            return False
        size = self._size(str(record.trajectory_hash))
        if self._kept + size > MOST_KEPT:
            return False
        self._kept += size
        return True

    def _size(self, trajectory_hash: str) -> int:
        """Bytes of a trajectory in the night's folder, 0 where it is not there."""
        path = self.folder / "trajectories" / f"{trajectory_hash}.npz"
        return path.stat().st_size if path.is_file() else 0

    def _tally(self, key: Key) -> Sight:
        return self.tallies.setdefault(key, Sight(experiment=key[0], case=key[1]))


def _cell(trial: Trial) -> Cell:
    return trial.experiment.name, trial.case, trial.engine, trial.track
