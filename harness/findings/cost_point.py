"""One trial on the plane of error and cost."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
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
