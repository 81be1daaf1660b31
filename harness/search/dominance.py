"""Is 'tuned' beaten by a change of one of its own knobs? A cheap pass over all changes, then a clock for those that may win.

The first round is the track as it is. The second has one run of every change: each knob that means something in the scene at
each of its values, but for those at which the engine resolves its settings as before, and the track 'default'. A change that
keeps every check that 'tuned' keeps and one more is better; so is one that costs under two thirds at an error no larger; and
'default' also if it errs less. What a change costs is known roughly by then, so those that seem to cost less than three
quarters may win. Each of them is clocked beside 'tuned', and, one of each knob, tried at drawn parameters as well: there the
same is asked again.

A change of a track that keeps all its checks can win by its cost alone, so its run is broken off once it is dearer.

Is an engine better off with one knob turned? Two runs of the same question are compared by their checks, error and cost.

A bound is the stricter, the shorter the steps that an engine takes, so each check holds both runs to the looser of their two
bounds. Errors within a tenth of each other are alike, and so are errors below a floor. It is the largest of what the truth may
be off, 1e-9 of the case's scale (below which the price list draws no difference either) and a hundredth of the headline's
bound: bounds are leading terms (a step's way, g dt T/2), and of two answers that are right a hundredfold the terms that the
derivation leaves out decide which is the better.
"""

import math
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.features import features_of
from plumbline.harness.case import Case
from plumbline.harness.store.record import Record
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.foreseen_cost import NoScene, scene_at, too_much
from plumbline.harness.study.one_knob import KnobTurn, label_of, turn_between, turned, turns
from plumbline.harness.study.trial import Trial

UNDER = 2 / 3
"""A change that errs no more and costs less than this share of the track is better."""
ALIKE = 1.1
"""An error is larger than another if it is more than this many times as large."""
LEAST_ERROR = 1e-9
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
class RunFigures:
    """What one run gave. Terms: checks: those that could be measured, by their number. error: of the headline, nan without an
    answer. off: what the truth may be off there."""

    answered: bool
    checks: Mapping[int, _Checked]
    error: float
    off: float


def run_of(question: Question, status: str, measurements: Iterable[Mapping[str, Any]]) -> RunFigures:
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
    return RunFigures(answered, checks, error, off)


def run_of_record(question: Question, record: Record) -> RunFigures:
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


def compared(question: Question, track: RunFigures, change: RunFigures) -> Comparison | None:
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


def _names(number: int, *runs: RunFigures) -> set[str]:
    return {run.checks[number].metric for run in runs if number in run.checks}


def _ratio(question: Question, track: RunFigures, change: RunFigures, bounds: Sequence[float]) -> float:
    """The change's error over the track's, both at least the floor; of what is better the higher, the other way round."""
    before, after = track.error, change.error
    if math.isnan(after):
        return math.nan if math.isnan(before) else math.inf
    if math.isnan(before):
        return 0.0
    if question.headline in question.higher:
        return before / after if after > 0 else (math.inf if before > 0 else 1.0)
    floor = max(track.off, change.off, LEAST_ERROR * question.scale, SHARE * max([0.0, *bounds]))
    if math.isinf(floor):
        return 1.0
    return max(after, floor) / max(before, floor)


FACTORS = (0.5, 0.8, 1.25, 2.0)
"""By each of these one numeric parameter of a case is multiplied, drawn from the case's name and the factor."""
MAYBE = 0.75
"""A change whose rough cost is below this share of the track's may cost under two thirds."""
LEAST = 5.0
"""A change may take at least so long [s]: judging its answer may last longer than its steps."""
DEARER = 1.5
"""A change that can win by its cost alone is broken off after this many times what the track's steps took."""
PATIENT = 20.0
"""The same, if it can win by its checks."""


@dataclass(frozen=True, slots=True)
class _TriedChange:
    """A change with its record and how it stands beside the track. Terms: cost: over the track's, roughly; nan if unknown."""

    trial: Trial
    record: Record
    beside: Comparison
    cost: float

    @property
    def may_win(self) -> bool:
        """Is it better, unless the clock says that it is not cheap enough?"""
        if self.beside.more or (self.trial.track == "default" and self.beside.errs_less):
            return True
        return self.beside.as_good and self.cost < MAYBE

    @property
    def rank(self) -> tuple[bool, float]:
        """Of two that may win with the same knob, the smaller is tried at drawn parameters."""
        return not self.beside.more, self.cost if math.isfinite(self.cost) else math.inf


def next_trials(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> list[Trial]:
    """The next round over all cases and engines; empty after the drawn parameters."""
    probes: list[Trial] = []
    for group in _groups(trials):
        first = group[0]
        case, adapter, last = cases[first.case], adapters[first.engine], max(trial.round for trial in group)
        if last == 0:
            probes += _changes(first, records.get(first.trial), case, adapter)
        elif last == 1:
            probes += _at_drawn_parameters(group, records, case)
    return probes


def due_for_clock(trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case]) -> set[str]:
    """Changes that may win, each with the track beside it, at the case's own parameters and at drawn ones."""
    due: set[str] = set()
    for group in _groups(trials):
        for parameters in {repr(trial.parameters): trial.parameters for trial in group}.values():
            here = [trial for trial in group if trial.parameters == parameters]
            better = [seen.trial.trial for seen in _seen(here, records, cases[here[0].case]) if seen.may_win]
            due |= {*better, *(trial.trial for trial in here if trial.track == "tuned")} if better else set()
    return due


def kept_parameters(experiment: Experiment, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Those that say which scene of an experiment a trial belongs to, whatever was drawn: swept ones, and the seed."""
    return {name: value for name, value in parameters.items() if name in experiment.parameters or name == "seed"}


def changes_of(trial: Trial, record: Record | None, case: Case, adapter: Adapter) -> list[KnobTurn]:
    """The turns of one knob that a track is tried with. Args: record: of the track, None where it has none yet."""
    scene = trial.scene(case)
    if features_of(scene) & ~adapter.features:
        return []
    idle = () if record is None else record.idle
    every = turns(trial.settings, adapter.knobs_in(scene), adapter.knobs)
    return [turn for turn in every if (turn.knob, turn.value) not in idle]


def drawn_parameters(experiment: Experiment, case: Case, given: Mapping[str, Any], dt: float) -> Iterator[dict[str, Any]]:
    """The parameters of a scene with one of them multiplied, for each factor another one is drawn.

    Left out are those that the experiment sweeps itself, what is no number or zero, seeds and numbers of worlds; and what the
    case has no scene for.
    """
    fixed = {"seed", case.worlds, *experiment.parameters}
    names = [name for name, value in given.items() if name not in fixed and type(value) in (int, float) and value]
    for factor in FACTORS:
        for name in random.Random(f"{case.name} {factor}").sample(names, len(names)):
            value = given[name] * factor
            other = {**given, name: value if type(given[name]) is float else max(1, round(value))}
            if other[name] != given[name] and _fits(case, other, dt):
                yield other
                break


def _fits(case: Case, parameters: Mapping[str, Any], dt: float) -> bool:
    try:
        return not too_much(case, scene_at(case, parameters), dt)
    except NoScene:
        return False


def _groups(trials: Sequence[Trial]) -> list[list[Trial]]:
    """The trials of one scene on one engine, at its own parameters first."""
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.experiment.dominance:
            kept = kept_parameters(trial.experiment, trial.parameters)
            name = (trial.experiment.name, trial.case, kept, trial.settings.dt, trial.engine)
            groups.setdefault(repr(name), []).append(trial)
    return [sorted(group, key=lambda trial: trial.round) for group in groups.values()]


def _changes(track: Trial, record: Record | None, case: Case, adapter: Adapter) -> Iterator[Trial]:
    if record is None or record.status in ("unavailable", "interrupted", "timeout"):
        return  # of a track that is not done in time each change would take its whole deadline as well
    allowed = _allowed(track, record)
    settled = changes_of(track, record, case, adapter)
    for turn in settled:
        yield track.probing(
            case,
            track=label_of("tuned", [(turn.name, turn.value)]),
            base="tuned",
            settings=turned(track.settings, turn.knob, turn.value),
            allowed=allowed,
            round=1,
        )
    if settled and "default" in adapter.tracks:
        settings = adapter.tracks["default"].with_dt(track.settings.dt)
        yield track.probing(case, track="default", settings=settings, allowed=allowed, round=1)


def _allowed(track: Trial, record: Record) -> float:
    """How long a change of a track may run [s]; 0 for as long as the experiment allows."""
    if not record.rough_cost or record.status not in ("passed", "failed"):
        return 0.0
    patience = DEARER if record.status == "passed" else PATIENT
    return min(track.experiment.deadline, LEAST + patience * record.rough_cost * record.sim_seconds)


def _seen(here: Sequence[Trial], records: Mapping[str, Record], case: Case) -> Iterator[_TriedChange]:
    """The changes at one set of parameters that gave an answer."""
    question = Question.of(case)
    track = next((records[trial.trial] for trial in here if trial.track == "tuned" and trial.trial in records), None)
    for trial in here if track is not None else ():
        record = records.get(trial.trial)
        if trial.track != "tuned" and record is not None and track is not None:
            beside = compared(question, run_of_record(question, track), run_of_record(question, record))
            if beside is not None:
                yield _TriedChange(trial, record, beside, _cost(track, record))


def _cost(track: Record, change: Record) -> float:
    if change.rough_ratio is not None:
        return change.rough_ratio
    return change.rough_cost / track.rough_cost if change.rough_cost and track.rough_cost else math.nan


def _at_drawn_parameters(group: Sequence[Trial], records: Mapping[str, Record], case: Case) -> Iterator[Trial]:
    """The track and, of each knob, the change that is most likely to win, at parameters that are drawn."""
    chosen: dict[str, _TriedChange] = {}
    for seen in sorted((seen for seen in _seen(group, records, case) if seen.may_win), key=lambda seen: seen.rank):
        turn = turn_between(group[0].settings.plain(), seen.trial.settings.plain())
        chosen.setdefault(seen.trial.track if turn is None else turn.knob, seen)
    if not chosen:
        return
    first = group[0]
    for parameters in drawn_parameters(first.experiment, case, first.parameters, first.settings.dt):
        for trial in (first, *(seen.trial for seen in chosen.values())):
            yield trial.probing(case, parameters=parameters, allowed=0.0, round=2)
