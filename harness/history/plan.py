"""In which order a night goes through its blocks, and which of them its budget leaves out."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import InitVar, dataclass, field
from statistics import mean
from typing import Any, Literal, TypeAlias

from plumbline.harness.history.blocks import Block, Key, Seen

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
