"""Is an engine better off with one knob turned? Two runs of the same question are compared by their checks, error and cost.

A bound is the stricter, the shorter the steps that an engine takes, so each check holds both runs to the looser of their two
bounds. Errors within a tenth of each other are alike, and so are errors below a floor. It is the largest of what the truth may
be off, 1e-9 of the case's scale (below which the price list draws no difference either) and a hundredth of the headline's
bound: bounds are leading terms (a step's way, g dt T/2), and of two answers that are right a hundredfold the terms that the
derivation leaves out decide which is the better.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from plumbline.harness.case import Case
from plumbline.harness.store.record import Record

UNDER = 2 / 3
"""A change that errs no more and costs less than this share of the track is better."""
ALIKE = 1.1
"""An error is larger than another if it is more than this many times as large."""
LEAST = 1e-9
"""Of the case's scale."""
SHARE = 0.01
"""Of the headline's bound."""
ANSWERED = ("passed", "failed")


@dataclass(frozen=True, slots=True)
class Question:
    """What runs are judged by. Terms: higher: the checked metrics of which more is better."""

    headline: str
    scale: float
    higher: frozenset[str]

    @classmethod
    def of(cls, case: Case) -> "Question":
        """Of a case."""
        higher = (check.metric.name for check in case.checks if check.metric.better == "higher")
        return cls(case.headline, case.scale, frozenset(higher))

    @classmethod
    def described(cls, case: Mapping[str, Any]) -> "Question":
        """Of a case as a catalogue has it."""
        higher = (check["metric"] for check in case["checks"] if check["better"] == "higher")
        return cls(case["headline"], case["scale"], frozenset(higher))


@dataclass(frozen=True, slots=True)
class _Checked:
    metric: str
    value: float
    bound: float


@dataclass(frozen=True, slots=True)
class Run:
    """What one run gave. Terms: checks: those that could be measured, by their number. error: of the headline, nan without an
    answer. off: what the truth may be off there."""

    answered: bool
    checks: Mapping[int, _Checked]
    error: float
    off: float


def run_of(question: Question, status: str, measurements: Iterable[Mapping[str, Any]]) -> Run:
    """A run by its rows of measurements, in their order: the checks of the case come first."""
    checks: dict[int, _Checked] = {}
    error, off, answered = math.nan, 0.0, False
    for number, row in enumerate(measurements if status in ANSWERED else ()):
        answered = True  # settings that are refused fail without a single measurement
        bound = row["at_most"]
        if bound is not None and not math.isnan(bound) and row["passed"] in (True, False):
            checks[number] = _Checked(row["metric"], float(row["value"]), float(bound))
        if row["metric"] == question.headline and math.isnan(error):
            error, off = abs(float(row["value"])), float(row["truth_error"])
    return Run(answered, checks, error, off)


def run_of_record(question: Question, record: Record) -> Run:
    """A run by its record."""
    return run_of(question, record.status, [asdict(measurement) for measurement in record.measurements])


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A change beside the track.

    Terms: held: of `checks`, how many hold on the track and with the change. more: does the change keep all that the track
    keeps, and another one? fewer: does it lose one? ratio: of the errors, above the floor; nan where none has one.
    """

    held: tuple[int, int]
    checks: int
    more: bool
    fewer: bool
    ratio: float

    @property
    def as_good(self) -> bool:
        """Does the change lose nothing: no check, and no accuracy?"""
        return not self.fewer and not self.ratio > ALIKE

    @property
    def errs_less(self) -> bool:
        """Is the track's error larger, and does the change lose no check?"""
        return not self.fewer and self.ratio * ALIKE < 1.0


def compared(question: Question, track: Run, change: Run) -> Comparison | None:
    """A change beside the track; None if the change gave no answer."""
    if not change.answered:
        return None
    numbers = sorted({*track.checks, *change.checks})
    held: list[set[int]] = [set(), set()]
    bounds: dict[int, float] = {}
    for number in numbers:
        both = [run.checks[number] for run in (track, change) if number in run.checks]
        higher = both[0].metric in question.higher
        bounds[number] = (min if higher else max)(one.bound for one in both)
        for side, run in zip(held, (track, change), strict=True):
            if number in run.checks and _holds(run.checks[number].value, bounds[number], higher):
                side.add(number)
    kept, won = held
    headlines = [bounds[number] for number in numbers if question.headline in _names(number, track, change)]
    return Comparison(
        held=(len(kept), len(won)),
        checks=len(numbers),
        more=won > kept,
        fewer=bool(kept - won),
        ratio=_ratio(question, track, change, headlines),
    )


def _holds(value: float, bound: float, higher: bool) -> bool:
    return math.isfinite(value) and (value >= bound if higher else value <= bound)


def _names(number: int, *runs: Run) -> set[str]:
    return {run.checks[number].metric for run in runs if number in run.checks}


def _ratio(question: Question, track: Run, change: Run, bounds: Sequence[float]) -> float:
    """The change's error over the track's, both at least the floor; of what is better the higher, the other way round."""
    before, after = track.error, change.error
    if math.isnan(after):
        return math.nan if math.isnan(before) else math.inf
    if math.isnan(before):
        return 0.0
    if question.headline in question.higher:
        return before / after if after > 0 else (math.inf if before > 0 else 1.0)
    floor = max(track.off, change.off, LEAST * question.scale, SHARE * max([0.0, *bounds]))
    if math.isinf(floor):
        return 1.0
    return max(after, floor) / max(before, floor)
