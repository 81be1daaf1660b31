"""A night's run, steered by its history: known results are reused, a random share of them is computed again.

What an engine answered to a case before a night in which it gave another answer to the same digest is not recalled any more.
"""

import math
import sys
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.findings.changes.prices import TOLD
from plumbline.harness.history.blocks import (
    LATELY,
    Block,
    Cell,
    Key,
    NightSight,
    Plan,
    blocks_of,
    last_seen,
    last_unanswered,
    sights_of,
)  # fmt: skip
from plumbline.harness.history.budget import Budget
from plumbline.harness.history.folder import MACHINE_BOUND, NIGHT, SCHEMA, History, Night, Pool
from plumbline.harness.history.known_searches import KnownSearches
from plumbline.harness.run.interrupt import UnderWay
from plumbline.harness.run.known_results import Guide
from plumbline.harness.store import disk
from plumbline.harness.store.journal import DamagedFile, StoreError, read_journal
from plumbline.harness.store.machine_fingerprint import fingerprint, machine_digest
from plumbline.harness.store.record import Record, Timing, digest
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.study.study import Study
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


@dataclass(frozen=True, slots=True, kw_only=True)
class NightWish:
    """What a night is asked for. Terms: budget [s], infinite for none. gated: engines that may not be worse; least: share of
    what they were asked that has to be judged. seed: of what is drawn, '' for the night's own name."""

    study: Study
    cases: Mapping[str, Case]
    adapters: Mapping[str, Adapter]
    budget: float = math.inf
    workers: int = 2
    keep: Keep = "changed"
    gated: tuple[str, ...] = ()
    least: float = 0.0
    seed: str = ""

    @property
    def digest(self) -> str:
        """Another one for a night that asks something else."""
        return digest([repr(self.study), sorted(self.cases), sorted(self.adapters)])


class Steering(Guide):
    """One night on its way: the guide of its run, and in the end what was done.

    Terms:
        before: whole nights that can be read, the earliest first; unread: why others cannot. seen: what these say of each
        block; waited: trials for which they waited in vain, by the last of them. distrusted: by case and engine, the night
        before which nothing is recalled. hashes: of trajectories that stay. out, unanswered: rows of `night.json`, what was
        left out, and what was waited for when time was up. sitting: 0, as a night may end after any question.
    """

    sitting = 0.0

    def __init__(
        self, history: History, night: Night, request: NightWish, before: Sequence[Night], unread: Sequence[DamagedFile]
    ) -> None:
        """Begin, or go on where the night was broken off. Raises: StoreError."""
        self.history, self.night, self.request, self.before, self.unread = history, night, request, before, unread
        self.seed, self.pool, self.machine = request.seed or night.stamp, Pool(history.pool), machine_digest(fingerprint())
        self.budget = Budget.of(request.budget, (earlier.plan for earlier in before[-LATELY:]))
        self.seen = last_seen(before)
        self.waited = last_unanswered(before, self.seen)
        self.searched = KnownSearches(self.seen, request.cases, self.pool, self.seed)
        self.blocks: tuple[Block, ...] = ()
        self.done, self.begun, self.hashes = set[Key](), set[Key](), set[str]()
        self.out, self.unanswered = list[dict[str, Any]](), list[dict[str, Any]]()
        self._plan, self._again = Plan((), {}, {}), dict[str, Record]()
        self._mark = self._clocking = 0.0
        self._kept = 0
        self.tallies = {sight.key: sight for sight in sights_of(night)}
        last = before[-1].plan.get("distrusted", ()) if before else ()
        self.distrusted = {(case, engine): stamp for case, engine, stamp in last}
        for record in read_journal(night.folder / "journal.jsonl").values():
            if record.disagrees:
                self.distrusted[record.case, record.engine] = night.stamp
            if record.trajectory_kept and (kept := record.trajectory_hash or "") not in self.hashes:
                new = not record.recalled and not self.pool.trajectory_path(kept).is_file()
                self._kept += self._size(kept) if new else 0
                self.hashes.add(kept)

    def save(self) -> None:
        """Keep what the night has to know if it goes on, and draw anew what is set aside for its end. Raises: OSError."""
        self.budget.set_aside(sum(tally.answers for tally in self.tallies.values()), self.slow)
        endless = math.isinf(self.request.budget)
        about = {name: getattr(self.request, name) for name in ("keep", "least")}
        about |= {"schema": SCHEMA, "stamp": self.night.stamp, "asked": self.request.digest, "study": self.request.study.name}
        about |= {"budget": None if endless else self.request.budget, "seed": self.seed, "gated": list(self.request.gated)}
        write_json(self.night.folder / NIGHT, about | {"complete": False, "blocks": self.sights({}, {})})

    def batches(self, trials: Sequence[Trial]) -> Iterator[list[Trial]]:
        """Block after block, the most valuable first, as long as there is time."""
        self.blocks = blocks_of(trials)
        due = {block.key: self._due(block) for block in self.blocks}
        stuck = {cell[:2]: stamp for cell, stamp in self.waited.items()}
        self._plan = plan = Plan(self.blocks, self.seen, due, stuck)
        for batch in plan.batches(self.budget.left):
            self._mark = time.monotonic()
            self.begun |= {block.key for block in batch}
            yield sorted((trial for block in batch for trial in block.trials), key=lambda trial: _cell(trial) in self.waited)
            self.done |= {block.key for block in batch}
            for block in batch:
                tally = self._tally(block.key)
                plan.taken[block.key] = tally.answer_seconds + tally.clock_seconds
            self.tidy()
            self.save()

    @cached_property
    def store(self) -> Store:
        """The tables of the night, once it is carried out. Raises: NoRun."""
        return self.night.store()

    @property
    def slow(self) -> float:
        """Times as long as foreseen."""
        return self._plan.slow

    def known(self, trial: Trial) -> Record | None:
        """From the pool, unless it is drawn to be computed again, depends on the machine, or is distrusted."""
        found = self._pooled(trial, trial.trial)
        if found is None:
            return None
        if computed_again(trial.trial, self.seed):
            self._again[trial.trial] = found
            return None
        self._tally((trial.experiment.name, trial.case)).answers += 1
        kept = found.trajectory_hash is not None and self._link(found.trajectory_hash)
        return replace(found, round=trial.round, trajectory_kept=kept)

    def alike(self, trial: Trial) -> Record | None:
        """The last answer to what a trial asks, where only what judges it was edited since, and its trajectory was kept."""
        before = self.searched.last_answer(trial)
        if before is None or before.motion != trial.motion or computed_again(trial.trial, self.seed):
            return None
        last = self._pooled(trial, before.trial)
        kept = None if last is None else last.trajectory_hash
        return last if kept is not None and self.pool.lay(self._path(kept)) else None

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
                self.distrusted[record.case, record.engine] = self.night.stamp
        record = replace(record, trajectory_kept=self._stays(trial, record))
        if record.again != record.answer:
            try:
                self.pool.keep(record, self.night.stamp)
            except DamagedFile as error:
                print(f"{error}; the answer is kept by the night alone", file=sys.stderr)
        return record

    def beside(self, trials: Sequence[Trial], records: Mapping[str, Record]) -> list[Trial]:
        """Where the searches of earlier nights ended."""
        del records
        return self.searched.beside(trials)

    def searches(self, trial: Trial, records: Mapping[str, Record]) -> bool:
        """Limits are searched as far as they have to; fronts where they are not known, or err otherwise now."""
        known = self._pooled(trial, trial.trial) is not None
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
            before = None if trial is None or not timing.unstable_timing else self.searched.last_answer(trial)
            if before is not None and (timing.cpu_per_unit or 0.0) > (1 + TOLD) * (before.cpu_per_unit or math.inf):
                return self.budget.left() > self._clocking
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
        plan = self._plan
        self.out += [plan.left_out(b, "time was up half-way") for b in self.blocks if b.key in self.begun - self.done]
        for block in plan.waiting:
            dear = self.budget.left() > 0.0 and plan.foreseen(block) is not None
            self.out.append(plan.left_out(block, "it is foreseen to take longer than was left" if dear else "no time was left"))
        self.tidy()

    def tidy(self) -> None:
        """Put the trajectories that are kept into the pool, take the others away. Raises: OSError."""
        for path in sorted((self.night.folder / "trajectories").glob("[!.]*.npz")):
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

    def _pooled(self, trial: Trial, name: str) -> Record | None:
        """What is known under a name, to be recalled for a trial."""
        try:
            found = self.pool.answer(name)
        except StoreError as error:
            print(f"{error}; its answer is computed again", file=sys.stderr)
            return None
        if found is None or (found.status in MACHINE_BOUND and found.answered_on != self.machine):
            return None
        return None if found.recalled < self.distrusted.get((trial.case, trial.engine), "") else found

    def _link(self, trajectory_hash: str) -> bool:
        """Lay a trajectory of the pool into the night: does it stay there?"""
        path = self._path(trajectory_hash)
        if self.request.keep == "none" or not (path.is_file() or self.pool.lay(path)):
            return False
        self.hashes.add(trajectory_hash)
        return True

    def _stays(self, trial: Trial, record: Record) -> bool:
        """Does a computed trajectory stay?"""
        own, keep = record.trajectory_hash, self.request.keep
        if own is None or keep == "none":
            return False
        if not self.pool.trajectory_path(own).is_file():
            before = self.searched.last_answer(trial)
            as_before = before is not None and (before.status, before.trajectory_hash) == ("passed", own)
            size = self._size(own)
            if (keep == "changed" and record.status == "passed" and as_before) or self._kept + size > MOST_KEPT:
                return False
            self._kept += size
        self.hashes.add(own)
        return True

    def _path(self, trajectory_hash: str) -> Path:
        return self.night.folder / "trajectories" / f"{trajectory_hash}.npz"

    def _size(self, trajectory_hash: str) -> int:
        """Bytes of a trajectory in the night's folder, 0 where it is not there."""
        path = self._path(trajectory_hash)
        return path.stat().st_size if path.is_file() else 0

    def _tally(self, key: Key) -> NightSight:
        return self.tallies.setdefault(key, NightSight(experiment=key[0], case=key[1]))


def _cell(trial: Trial) -> Cell:
    return trial.experiment.name, trial.case, trial.engine, trial.track
