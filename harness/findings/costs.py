"""What a step, a ray or a world costs: a price with what it buys, prices along a parameter, and how they grow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.order import FEWEST, Order, fit_order

TELLING = 1.0
"""The widest 95 % interval of an exponent that is stated.

Laws of growth that people tell apart are whole powers: constant, linear, quadratic. An interval narrower than the distance
between two of them holds one at most; a wider one always holds one and may hold two, and does not say whether twice the size
costs twice or four times as much. Three sizes leave a single degree of freedom, where Student's t is 12.7: over two decades a
price at the middle one that is off by a sixth makes the interval that wide."""

PENETRATION = ("overlap", "penetration")
"""Metrics [m] that say how deep bodies stand in one another, the more trusted one first."""
RESIDUAL = ("rms_speed",)
SMALLEST = {"penetration": 1e-6, "residual": 1e-5, "error": 1e-6}
"""Below a micrometre, 10 micrometres a second, or a millionth of an error's unit, two answers count as equally good."""
WHOLE = {"ray": ("cast", "rays"), "world-step": ("batch-step", "worlds")}
"""Where the number of what is counted is swept, the price of all together, and the name of that number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """A row: one engine under one group of settings in one scene.

    Terms:
        where: the parameters that tell the scene from the case's others. unit: what is counted. cpu [s]: of one unit.
        to_fastest: over the fastest setting whose checks hold of any engine that people can deploy. reference: what the
        reference engine takes over this row, at its fastest setting that penetrates no more and moves no more (or, without
        contact, errs no more) than this row; reference_setting names it.
        penetration [m]; residual [m/s]: root mean square speed of the worst body when all should rest; error: the case's
        headline metric. best: is this the engine's fastest setting whose checks hold?
        clocks, workers: as in `harness.study.trial.Trial`. units: rays of a cast, worlds of a step. to_plain: over the plain
        step of the same engine and setting, where something else was clocked. rate [1/s]: units that all processes get done in
        a second of wall time; efficiency: that over `workers` times the rate of one process; where several stepped side by
        side. emulated: the share of the price (0 to 1) that is the adapter's own laws; None where it was not measured.
    """

    case: str
    where: str
    parameters: Mapping[str, Any]
    engine: str
    track: str
    unit: str
    cpu: Interval | None
    to_fastest: Interval | None
    reference: Interval | None
    reference_setting: str
    penetration: float | None
    residual: float | None
    error: float | None
    error_metric: str
    best: bool
    unstable: bool | None
    status: str
    reason: str
    dt: float
    trial: str
    experiment: str = ""
    clocks: str = "work"
    workers: int = 1
    units: int = 1
    to_plain: Interval | None = None
    rate: float | None = None
    efficiency: Interval | None = None
    emulated: float | None = None

    @property
    def beside(self) -> bool:
        """Does it belong to a study of what stands beside the work?"""
        return "clocked" in self.parameters or "workers" in self.parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """Rows of all engines that differ in one numeric parameter, by its size; where: what else tells them from the case.

    Where the parameter decides how many rays or worlds there are, the rows show that number and the price of all of them.
    """

    case: str
    where: str
    unit: str
    parameter: str
    rows: tuple[Cost, ...]


@dataclass(frozen=True, slots=True)
class Exponent:
    """How the price of one engine under one group of settings grows along a sweep: fit: cost = C parameter^order above a floor,
    between two values of the parameter."""

    sweep: Sweep
    engine: str
    track: str
    fit: Order

    @property
    def telling(self) -> bool:
        """Is the exponent known well enough to be stated? Elsewhere its interval alone is."""
        return self.fit.high - self.fit.low <= TELLING


def growth(sweep: Sweep, rows: Sequence[Cost]) -> Exponent | None:
    """The exponent of the price along a sweep for the rows of one engine; None below three values."""
    points = [(float(row.parameters[sweep.parameter]), row.cpu.value) for row in rows if row.cpu is not None]
    fit = fit_order([x for x, _ in points], [y for _, y in points])
    return None if fit is None else Exponent(sweep, rows[0].engine, rows[0].track, fit)


def whole(sweep: Sweep) -> Sweep:
    """Prices of all rays or worlds together over their number, where that is what the parameter decides."""
    if sweep.unit not in WHOLE or len({row.units for row in sweep.rows}) < FEWEST:
        return sweep
    unit, name = WHOLE[sweep.unit]
    kept = [{n: v for n, v in row.parameters.items() if n != sweep.parameter} for row in sweep.rows]
    rows = [
        replace(
            row,
            unit=unit,
            parameters=others | {name: row.units},
            cpu=row.cpu and row.cpu.times(row.units),
        )
        for row, others in zip(sweep.rows, kept, strict=True)
    ]
    return replace(sweep, unit=unit, parameter=name, rows=tuple(sorted(rows, key=lambda row: row.units)))


def no_worse(own: Cost, other: Cost) -> bool:
    """Does one answer penetrate no more and move no more than another (or, where neither is known, err no more)?"""
    names = [name for name in ("penetration", "residual") if getattr(other, name) is not None] or ["error"]
    for name in names:
        mine, theirs = getattr(own, name), getattr(other, name)
        if mine is None or theirs is None or max(mine, SMALLEST[name]) > max(theirs, SMALLEST[name]):
            return False
    return True
