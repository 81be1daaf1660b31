"""The timing samples of a run by trial and block, and one price over another within the blocks that both were sampled in."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.ratio import ratio
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store

SampledBlock = tuple[int, int]
"""The number of a process, and that of a block in it."""
Clock = Literal["cpu", "wall"]


@dataclass(frozen=True, slots=True)
class BlockSample:
    """What a trial was clocked at in one block.

    Terms: count: units that were done, of all steps together; units: of one step, as in `harness.store.record.Sample`.
    cpu, wall [s]: of all of them; nan where it was not recorded.
    """

    count: int
    units: int
    cpu: float
    wall: float

    def of_a_unit(self, clock: Clock = "cpu") -> float:
        """Seconds of a unit."""
        return (self.cpu if clock == "cpu" else self.wall) / self.count


def samples_by_block(store: Store) -> Mapping[str, Mapping[SampledBlock, BlockSample]]:
    """By trial; a trial that was not clocked has none."""
    samples: dict[str, dict[SampledBlock, BlockSample]] = {}
    for row in records(store.samples):
        units = int(row["units"]) if pd.notna(row.get("units")) else 1
        samples.setdefault(str(row["trial"]), {})[row["process"], row["block"]] = BlockSample(
            count=int(row["steps"]) * units, units=units, cpu=float(row["cpu"]), wall=float(row.get("wall", math.nan))
        )
    return samples


def ratio_in_blocks(
    cost: Mapping[SampledBlock, BlockSample], base: Mapping[SampledBlock, BlockSample], clock: Clock = "cpu"
) -> Interval | None:
    """Time of a unit of one trial over that of another; None where no block sampled both."""
    both = sorted(cost.keys() & base.keys())
    if not both:
        return None
    mine, other = (np.array([samples[block].of_a_unit(clock) for block in both]) for samples in (cost, base))
    return ratio(mine, other, [process for process, _ in both])
