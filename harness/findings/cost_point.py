"""One trial on the plane of error and cost, with its timing samples and the settings that were tried beside it, and the step at
which a trend of such would come down to an error that no run reached.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Literal

import numpy as np
import pandas as pd

from plumbline.harness.search.front import RUNS
from plumbline.harness.statistics.bootstrap import ratio
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import fit_order
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import experiments_of

FORESIGHT = 1e-6
"""Share of the finest step that was run beyond which no trend is followed: rounding grows with the steps, and comes first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostPoint:
    """One trial on the plane of error and cost.

    Terms:
        substeps: that dt was taken in. substep [s]: the step that was really taken. error: share of the scale; off: by how
        much the truth may be off, likewise. cost: CPU seconds per simulated second or unit, with the 95 % interval; of an
        unclocked trial the rough cost alone. emulated: the share of the cost (0 to 1) that is the adapter's own laws,
        None where it was not measured. front: does no clocked point of the same engine beat it? best: none of any engine?
    """

    case: str
    where: str
    engine: str
    track: str
    dt: float
    substeps: int
    error: float
    off: float
    cost: Interval
    clocked: bool
    unstable: bool
    status: str
    trial: str
    substep: float
    emulated: float | None
    front: bool
    best: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Foreseen:
    """Where a trend meets a target. Terms: dt [s]; order: of its error in the step; track: the settings that follow it."""

    dt: float
    order: float
    track: str


def foreseen(points: Sequence[CostPoint], target: float) -> Foreseen | None:
    """The cheapest step at which an error of these points of one engine, none of which comes down to it, would be `target`.

    Settings count whose error shrinks with the step down to the finest that was run: the fit reaches no floor, its interval
    leaves out an order of zero, and its three finest points alone have half of its order or more. The trend is followed from
    the finest point on, no farther than to `FORESIGHT` of its step, and a step that is finer by a factor costs that many times
    more.
    """
    candidates: list[tuple[float, Foreseen]] = []
    for track, mine in grouped(points, attrgetter("track")).items():
        fit = fit_order([point.dt for point in mine], [point.error for point in mine])
        last = min(mine, key=lambda point: point.dt)
        if fit is None or fit.floor is not None or fit.low <= 0 or fit.at_fine_end < fit.order / 2:
            continue
        finer = (target / last.error) ** (1 / fit.order)
        if finer < FORESIGHT:
            continue
        candidates.append((last.cost.value / finer, Foreseen(dt=last.dt * finer, order=fit.order, track=track)))
    return min(candidates, key=lambda candidate: candidate[0], default=(0.0, None))[1]


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


Ended = Literal["no search", "nothing left to try", "all points spent"]
ALIKE = 1.5
"""How many times as many settings may be tried of one engine as of another in the same case."""


def efforts(store: Store, trials: pd.DataFrame) -> dict[str, tuple[int, Ended]]:
    """By engine, of the trials of one case at one set of parameters: how many settings were tried, and why there are no more.

    Settings are others whose answers differ, the ladder of both tracks among them; one that leaves every bit of a trajectory as
    it was is no other. 'nothing left to try' is where knobs and steps were used up, or what is left takes too long.
    """
    rooms = {experiment.name: experiment.sweep for experiment in experiments_of(store)}
    by_engine = {}
    rows = records(trials[["engine", "experiment", "trajectory_hash", "round"]])
    for engine, mine in grouped(rows, lambda row: str(row["engine"])).items():
        room = max(rooms.get(row["experiment"], 0) for row in mine)
        answers = {row["trajectory_hash"] for row in mine if isinstance(row["trajectory_hash"], str)}
        beyond = len(answers - {row["trajectory_hash"] for row in mine if row["round"] == 0})
        spent = beyond >= room or sum(row["round"] > 0 for row in mine) >= RUNS * room
        ended: Ended = "no search" if not room else "all points spent" if spent else "nothing left to try"
        by_engine[engine] = len(answers), ended
    return by_engine
