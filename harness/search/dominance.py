"""Is 'tuned' beaten by a change of one of its own knobs? A cheap pass over all changes, then a clock for those that may win.

The first round is the track as it is. The second has one run of every change: each knob that means something in the scene at
each of its values, but for those at which the engine resolves its settings as before, and the track 'default'. A change that
keeps every check that 'tuned' keeps and one more is better; so is one that costs under two thirds at an error no larger; and
'default' also if it errs less. What a change costs is known roughly by then, so those that seem to cost less than three
quarters may win. Each of them is clocked beside 'tuned', and, one of each knob, tried at drawn parameters as well: there the
same is asked again.

A change of a track that keeps all its checks can win by its cost alone, so its run is broken off once it is dearer.
"""

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.features import features_of
from plumbline.harness.case import Case
from plumbline.harness.search.better import Comparison, Question, compared, run_of_record
from plumbline.harness.store.record import Record
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.foreseen_cost import NoScene, scene_at, too_much
from plumbline.harness.study.one_knob import Turn, label_of, turn_between, turned, turns
from plumbline.harness.study.trial import Trial

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
class _Seen:
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


def changes_of(trial: Trial, record: Record | None, case: Case, adapter: Adapter) -> list[Turn]:
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


def _seen(here: Sequence[Trial], records: Mapping[str, Record], case: Case) -> Iterator[_Seen]:
    """The changes at one set of parameters that gave an answer."""
    question = Question.of(case)
    track = next((records[trial.trial] for trial in here if trial.track == "tuned" and trial.trial in records), None)
    for trial in here if track is not None else ():
        record = records.get(trial.trial)
        if trial.track != "tuned" and record is not None and track is not None:
            beside = compared(question, run_of_record(question, track), run_of_record(question, record))
            if beside is not None:
                yield _Seen(trial, record, beside, _cost(track, record))


def _cost(track: Record, change: Record) -> float:
    if change.rough_ratio is not None:
        return change.rough_ratio
    return change.rough_cost / track.rough_cost if change.rough_cost and track.rough_cost else math.nan


def _at_drawn_parameters(group: Sequence[Trial], records: Mapping[str, Record], case: Case) -> Iterator[Trial]:
    """The track and, of each knob, the change that is most likely to win, at parameters that are drawn."""
    chosen: dict[str, _Seen] = {}
    for seen in sorted((seen for seen in _seen(group, records, case) if seen.may_win), key=lambda seen: seen.rank):
        turn = turn_between(group[0].settings.plain(), seen.trial.settings.plain())
        chosen.setdefault(seen.trial.track if turn is None else turn.knob, seen)
    if not chosen:
        return
    first = group[0]
    for parameters in drawn_parameters(first.experiment, case, first.parameters, first.settings.dt):
        for trial in (first, *(seen.trial for seen in chosen.values())):
            yield trial.probing(case, parameters=parameters, allowed=0.0, round=2)
