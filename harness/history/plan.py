"""In which order a night goes through its blocks, and which of them its budget leaves out."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from statistics import mean
from types import MappingProxyType
from typing import Literal, TypeAlias

from plumbline.harness.history.blocks import Block, Key, Seen

Left: TypeAlias = Callable[[], float]
"""Seconds that are left, infinite without a budget."""
TROUBLED_SHARE, KNOWN_SHARE = 1 / 3, 2 / 3
"""Of a budget: for what is only noisy or was worse lately, so that the rest is seen too; and for all that was ever seen, while
something never was: a night that sees nothing twice notices nothing, one that sees nothing new never comes to the end."""
LARGEST, LONGEST = 12, 120.0
"""Blocks of a batch, and seconds that they are foreseen to take: a batch is clocked before the next one is answered."""

KNOWN_SECONDS = 10.0
"""Of foreseen work, from which on it says how slow a night is: below, the start of a process counts for too much."""

Why = Literal["no time was left", "it is foreseen to take longer than was left", "time was up half-way"]
"""Why a block was left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """A block that the budget left out. Terms: last_seen: the stamp of a night, '' for none. foreseen [s], None if unknown."""

    experiment: str
    case: str
    trials: int
    why: Why
    last_seen: str
    foreseen: float | None


def ranked(blocks: Collection[Block], seen: Mapping[Key, Seen], stuck: Mapping[Key, str] = MappingProxyType({})) -> list[Block]:
    """Most valuable first: what changed, what was worse or noisy lately, what was seen the longest time ago, what never was.

    Args: stuck: blocks in which nights came to their end without an answer, with the last such night: they follow all others.
    """

    def rank(block: Block) -> tuple[int, str]:
        if block.key in stuck:
            return 4, stuck[block.key]
        known = seen.get(block.key)
        if known is None:
            return 3, ""
        if known.sight.digest != block.digest:
            return 0, known.night.stamp
        return (1 if known.troubled else 2), known.night.stamp

    return sorted(blocks, key=rank)


@dataclass(slots=True)
class Plan:
    """What is left to do, and how long that will take.

    Terms:
        waiting: blocks in order. seen: by earlier nights. due: by block, the share of its answers that have to be computed.
        stuck: blocks that have a batch of their own, since they may not come to an end. taken [s]: by block, what it took
        tonight. promised [s]: by block, what it was foreseen to take when it was begun, where an earlier night knew.
    """

    waiting: list[Block]
    seen: Mapping[Key, Seen]
    due: Mapping[Key, float]
    stuck: Collection[Key] = ()
    taken: dict[Key, float] = field(default_factory=dict)
    promised: dict[Key, float] = field(default_factory=dict)

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
        """Blocks that fit into what is left, batch by batch; what does not stays behind in `waiting`.

        Where the shares leave time over in the end, what they held back follows.
        """
        news = any(block.key not in self.seen for block in self.waiting)
        troubled, known = TROUBLED_SHARE * left(), KNOWN_SHARE * left() if news else math.inf
        for shares in ({"troubled": troubled, "known": known}, {}):
            yield from self._within(left, shares)

    def _within(self, left: Left, shares: dict[str, float]) -> Iterator[list[Block]]:
        """The batches of one way through. Args: shares [s]: what blocks of a kind may take together."""
        skipped: list[Block] = []
        while self.waiting:
            batch, seconds, unknown = list[Block](), 0.0, set[str]()
            while self.waiting and len(batch) < LARGEST and seconds < LONGEST:
                block = self.waiting[0]
                if batch and {block.key, batch[-1].key} & {*self.stuck}:
                    break
                foreseen, counted = self.foreseen(block), [kind for kind in self._kinds(block) if kind in shares]
                if (foreseen is None and block.experiment in unknown) or (batch and (foreseen is None) != bool(unknown)):
                    break  # what one block of an experiment takes is learnt before others are begun, and keeps none waiting
                self.waiting.pop(0)
                if seconds + (foreseen or 0.0) >= left() or any((foreseen or 0.0) > shares[kind] for kind in counted):
                    skipped.append(block)
                    continue
                if foreseen is None:
                    unknown.add(block.experiment)
                for kind in counted:
                    shares[kind] -= foreseen or 0.0
                batch.append(block)
                seconds += foreseen or 0.0
                if foreseen is not None and block.key in self.seen:
                    self.promised[block.key] = foreseen
            if not batch:
                break
            yield batch
        self.waiting = skipped + self.waiting

    def left_out(self, block: Block, why: Why) -> LeftOut:
        """A block of these, as it is named."""
        known = self.seen.get(block.key)
        return LeftOut(
            experiment=block.experiment,
            case=block.case,
            trials=len(block.trials),
            why=why,
            last_seen="" if known is None else known.night.stamp,
            foreseen=self.foreseen(block),
        )

    def _kinds(self, block: Block) -> list[str]:
        """Which shares of the budget it counts for; what changed counts for none."""
        known = self.seen.get(block.key)
        if known is None or known.sight.digest != block.digest:
            return []
        return ["known", "troubled"] if known.troubled else ["known"]
