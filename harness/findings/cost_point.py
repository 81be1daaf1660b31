"""One trial on the plane of error and cost, and the step at which a trend of such would come down to an error that no run
reached."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

from plumbline.harness.statistics.order import fit_order
from plumbline.harness.store.rows import grouped

FORESIGHT = 1e-6
"""Share of the finest step that was run beyond which no trend is followed: rounding grows with the steps, and comes first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostPoint:
    """One trial on the plane of error and cost.

    Terms:
        substeps: that dt was taken in. substep [s]: the step that was really taken. error: share of the scale; off: by how
        much the truth may be off, likewise. cost, low, high: CPU seconds per simulated second or unit, with the 95 % interval;
        of an unclocked trial the rough cost alone. emulated: the share of the cost (0 to 1) that is the adapter's own laws,
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
    cost: float
    low: float | None
    high: float | None
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
        candidates.append((last.cost / finer, Foreseen(dt=last.dt * finer, order=fit.order, track=track)))
    return min(candidates, key=lambda candidate: candidate[0], default=(0.0, None))[1]
