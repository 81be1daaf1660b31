"""Where a case breaks: values ever harder are tried until one does, then the bracket around that place is halved.

Along an axis from easy to extreme the first values are spread evenly (by their logarithms, where both ends are positive) and
tried in this order, so that what is found is the first place that breaks and not some later one. A limit is a bracket: the
hardest value that held with all members of the ensemble before the first that did not, and that one. A value that an engine
crashed at is one that broke; where it ran out of time or memory, the search ends without a verdict beyond what had held.

Where the headline error has not doubled from the easy end to the first value that broke, the extreme is tried beside: a bar
that a constant crosses is no limit.

Where a case breaks, what is said to help is tried at the value that broke, and, where it does help, on from there towards the
extreme, in fewer values.

An axis makes a case harder. An error that has not doubled from the easy end to the extreme is what an engine does at every
value; where between them it crosses a bar says nothing of the axis.

What is said to help where a simulation breaks, each tried as it stands in textbooks and manuals.

Sources: Ericson, Real-Time Collision Detection (2005), section 2.4.3 (tunnelling); Catto, Solver2D (2024) (sub-steps rather
than iterations); Bender, Erleben, Trinkle, Interactive Simulation of Rigid Body Dynamics in Computer Graphics, Computer
Graphics Forum 33 (2014) 246 (iterations, damping, time steps); Hairer, Lubich, Wanner, Geometric Numerical Integration (2006),
chapter I (symplectic integrators); the PyBullet Quickstart Guide and MuJoCo's documentation, chapter Modeling (sizes, masses);
the documentation of an engine for what its adapter names (`Adapter.remedies`).
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Axis, Case
from plumbline.harness.case.alteration import Alteration
from plumbline.harness.scene import Effect
from plumbline.harness.store.record import Record
from plumbline.harness.study.experiment import Limit, axis_of
from plumbline.harness.study.one_knob import position, turned
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.ensemble import HEADLINE

DAMPING = 1.0
"""Added to every body [1/s]: a motion halves in 0.7 s."""
SPLIT = 4
"""By what a time step is divided, and by what sub-steps are multiplied."""


def remedied(sick: Trial, case: Case, adapter: Adapter, number: int, idle: Collection[tuple[str, Any]] = ()) -> Iterator[Trial]:
    """The trial that broke once more with each remedy that the engine and the case know, in round `number`.

    Args: idle: knobs and values that would change nothing there.
    """

    def tried(remedy: str, **changes: Any) -> Trial:
        return sick.probing(case, remedy=remedy, remedied=sick.trial, round=number, **changes)

    def settled(remedy: str, **settings: Any) -> Trial:
        return tried(remedy, settings=replace(sick.settings, **settings, source=f"remedy: {remedy}"))

    knobs, now = adapter.knobs, sick.settings
    along_step = axis_of(sick.experiment, case).parameter == "dt"
    if "substeps" in knobs:
        yield settled(f"sub-steps x {SPLIT}", substeps=SPLIT * (now.substeps or 1))
        if not along_step:
            yield settled(f"time step / {SPLIT}", dt=now.dt / SPLIT)
    elif not along_step:
        # Without sub-steps of its own an engine takes shorter steps: the same to it as to divide the time step.
        yield settled(f"sub-steps x {SPLIT}", dt=now.dt / SPLIT)
    most = max((value for value in knobs.get("iterations", ()) if value is not None), default=0)
    if most > (now.iterations or 0) and ("iterations", most) not in idle:
        yield settled("more iterations", iterations=most)
    for knob in ("solver", "integrator"):
        for value in knobs.get(knob, ()):
            if value is not None and value != getattr(now, knob) and (knob, value) not in idle:
                yield settled(f"{knob} {value}", **{knob: value})
    scene = sick.scene(case)
    for remedy, (knob, value) in adapter.remedies.items():
        if knob in adapter.knobs_in(scene) and position(now, knob) != value:
            yield tried(remedy, settings=replace(turned(now, knob, value), source=f"remedy: {remedy}"))
    if Effect.CONTACT in scene.effects and Effect.CONTINUOUS_COLLISION not in scene.effects:
        yield tried(
            "continuous collision", alteration=Alteration(name="continuous collision", widen=Effect.CONTINUOUS_COLLISION)
        )
    yield tried("damping", alteration=Alteration(name="damping", linear_damping=DAMPING, angular_damping=DAMPING))
    for name, parameters in case.eased.items():
        yield tried(name, parameters={**sick.parameters, **parameters})


DOUBLED = 2.0
"""By what an error has to grow from the easy end to the extreme to be a matter of the axis. One of first order grows by extreme
over easy, which is six at least in the catalogue."""


@dataclass(frozen=True, slots=True)
class ErrorAt:
    """The largest headline error of the starts at one value of an axis, and the bar beyond which it is lost, in its unit."""

    value: float
    error: float
    bar: float


def unchanged(points: Sequence[ErrorAt], easy: float, extreme: float) -> bool:
    """Is the error at the extreme less than twice that at the easy end? False where one of them is unknown."""
    at = {point.value: point.error for point in points}
    return easy in at and extreme in at and at[extreme] < DOUBLED * at[easy]


def extreme_untried(points: Sequence[ErrorAt], easy: float, broke: float, extreme: float) -> bool:
    """Has the error where an engine first broke not doubled since the easy end, with the extreme still untried?"""
    return extreme not in {point.value for point in points} and unchanged(points, easy, broke)


REMEDY_VALUES = 3
"""Values that a remedy which helps is tried at beyond the first, so that its bracket is a quarter of what was left."""
BROKE = ("failed", "crashed", "diverged")
ENDED = ("timeout", "oom", "unsupported", "unavailable", "interrupted")


@dataclass(frozen=True, slots=True)
class Bracket:
    """What is known along an axis. Terms: held, broke: the ends; None where none was found. stopped: a trial without answer."""

    held: float | None
    broke: float | None
    stopped: bool = False


@dataclass(frozen=True, slots=True)
class Ruler:
    """An axis with a measure: places from 0 at the easy end to 1 at the extreme.

    Terms: whole: only whole numbers are values. within: the ratio of a bracket's ends at which it is close enough.
    """

    axis: Axis
    whole: bool
    within: float

    @classmethod
    def of(cls, axis: Axis, parameters: Mapping[str, Any], limit: Limit | None) -> "Ruler":
        """The ruler of a search along the axis of a case with these parameters."""
        whole = isinstance(parameters.get(axis.parameter), int)
        return cls(axis, whole, math.inf if limit is None else limit.within)

    @property
    def _logarithmic(self) -> bool:
        return self.axis.easy > 0 and self.axis.extreme > 0

    def value(self, share: float) -> float:
        """The value at a place."""
        easy, extreme = self.axis.easy, self.axis.extreme
        value = easy * (extreme / easy) ** share if self._logarithmic else easy + (extreme - easy) * share
        if share in (0.0, 1.0):
            value = extreme if share else easy
        return float(round(value)) if self.whole else value

    def place(self, value: float) -> float:
        """The place of a value."""
        easy, extreme = self.axis.easy, self.axis.extreme
        if self._logarithmic:
            return math.log(value / easy) / math.log(extreme / easy)
        return (value - easy) / (extreme - easy)

    def close(self, held: float, broke: float) -> bool:
        """Is a bracket close enough?"""
        if self.whole and abs(held - broke) <= 1:
            return True
        if self._logarithmic:
            return max(held / broke, broke / held) <= self.within * (1 + 1e-12)
        # Ratios say nothing on an axis that begins at zero: its ends lie a quarter of what `within` grants apart there.
        return abs(held - broke) <= (self.within - 1) / 4 * abs(self.axis.extreme - self.axis.easy) * (1 + 1e-12)

    def scan(self, count: int) -> list[float]:
        """So many values from easy to extreme, each once."""
        return list(dict.fromkeys(self.value(k / (count - 1)) for k in range(count)))

    def between(self, held: float, broke: float) -> float:
        """The value half-way."""
        return self.value((self.place(held) + self.place(broke)) / 2)


def ruler(trial: Trial, case: Case) -> Ruler:
    """The ruler of the search that a trial belongs to."""
    return Ruler.of(axis_of(trial.experiment, case), case.parameters, trial.experiment.limit)


def value_of(trial: Trial, axis: Axis) -> float:
    """Where on the axis a trial stands."""
    return trial.settings.dt if axis.parameter == "dt" else float(trial.parameters[axis.parameter])


def bracket(known: Mapping[float, str], by: Ruler) -> Bracket:
    """What statuses by value say: the first value that broke, and the hardest before it that held."""
    ordered = sorted(known, key=by.place)
    broke = next((value for value in ordered if known[value] in BROKE), None)
    held = [value for value in ordered if known[value] == "passed" and (broke is None or by.place(value) < by.place(broke))]
    stopped = any(known[value] in ENDED for value in ordered)
    return Bracket(held[-1] if held else None, broke, stopped)


def next_value(known: Mapping[float, str], by: Ruler, scan: int) -> float | None:
    """Which value to try next; None where the bracket is close enough, or nothing is left to try."""
    interval = bracket(known, by)
    if interval.stopped:
        return None
    if interval.broke is None:
        return next((value for value in by.scan(scan) if value not in known), None)
    if interval.held is None or by.close(interval.held, interval.broke):
        return None
    middle = by.between(interval.held, interval.broke)
    return None if middle in known else middle


def next_trials(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> list[Trial]:
    """The next round over all searches; empty when every bracket is close enough."""
    probes: list[Trial] = []
    for group in searches_of(trials, cases):
        probes += _next_of(group, records, cases[group[0].case], adapters[group[0].engine], trials)
    return probes


def searches_of(trials: Sequence[Trial], cases: Mapping[str, Case]) -> list[list[Trial]]:
    """The trials of each search of experiments that have a limit."""
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.experiment.limit is not None:
            groups.setdefault(_search(trial, cases[trial.case]), []).append(trial)
    return list(groups.values())


def _search(trial: Trial, case: Case) -> str:
    """What the trials of one search have in common: all but the value and what follows from it."""
    axis = axis_of(trial.experiment, case)
    others = {name: value for name, value in trial.parameters.items() if name != axis.parameter}
    settings = replace(trial.settings, source="").plain()
    if axis.parameter == "dt":
        settings.pop("dt")
    side = (trial.engine, trial.track, trial.parts, trial.remedy, trial.remedied)
    return repr((trial.experiment.name, trial.case, others, side, settings))


def _next_of(
    group: Sequence[Trial], records: Mapping[str, Record], case: Case, adapter: Adapter, trials: Sequence[Trial]
) -> list[Trial]:
    first, by = group[0], ruler(group[0], case)
    limit = first.experiment.limit
    known = {value_of(trial, by.axis): records[trial.trial].status for trial in group if trial.trial in records}
    number = max(trial.round for trial in group) + 1
    scan = limit.scan if limit is not None else 2
    value = beyond(known, by) if first.remedied else next_value(known, by, scan)
    broke = bracket(known, by).broke
    if value is None and broke is not None and not first.remedied:
        points = [point for trial in group for point in _points(trial, records, by.axis)]
        value = by.axis.extreme if extreme_untried(points, by.axis.easy, broke, by.axis.extreme) else None
    if value is not None:
        return [_at(first, value, by.axis, case, number)]
    if first.remedied or limit is None or first.track not in limit.remedies or broke is None:
        return []
    sick = next(trial for trial in group if value_of(trial, by.axis) == broke)
    if any(trial.remedied == sick.trial for trial in trials):
        return []
    return list(remedied(sick, case, adapter, number, records[sick.trial].idle))


def _points(trial: Trial, records: Mapping[str, Record], axis: Axis) -> Iterator[ErrorAt]:
    """The headline error of a trial that has one."""
    for measurement in records[trial.trial].measurements if trial.trial in records else ():
        if measurement.metric == HEADLINE and measurement.at_most is not None:
            yield ErrorAt(value_of(trial, axis), measurement.value, measurement.at_most)


def _at(trial: Trial, value: float, axis: Axis, case: Case, number: int) -> Trial:
    if axis.parameter == "dt":
        return trial.probing(case, settings=trial.settings.with_dt(value), round=number)
    given = round(value) if isinstance(case.parameters[axis.parameter], int) else value
    return trial.probing(case, parameters={**trial.parameters, axis.parameter: given}, round=number)


def beyond(known: Mapping[float, str], by: Ruler) -> float | None:
    """Where to try next a remedy that holds where the case broke without it."""
    interval = bracket(known, by)
    if interval.stopped or interval.held is None or len(known) > REMEDY_VALUES:
        return None
    if interval.broke is None:
        return None if by.axis.extreme in known else by.axis.extreme
    if by.close(interval.held, interval.broke):
        return None
    middle = by.between(interval.held, interval.broke)
    return None if middle in known else middle
