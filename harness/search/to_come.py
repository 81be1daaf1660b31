"""What searches will still ask for: how many answers and clocks, in expectation, by what their trials have shown so far.

Along an axis the bracket says how often it is still halved. Where nothing broke yet, each value of the scan breaks with the
share of those that did so far. Of a sweep, the points that are left are spent at the pace at which its runs gave points; one
that finds less to try than a round may hold runs dry. Of the changes of a
track those that are not known to be idle are tried, and a share of them goes on to drawn parameters. A ladder is halved down to
its finest step as long as its budget allows; that it goes on beyond, and that perturbed starts follow, happens rarely.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

from harness.adapter import Adapter
from harness.case import Case
from harness.case.alteration import AS_IT_IS
from harness.search import dominance, first_break, front
from harness.search.remedies import remedied
from harness.store.record import Record
from harness.study.trial import Trial

__all__ = ["ToCome", "seconds_of_run", "to_come"]

BEHIND = 1
"""Rounds that a sweep may be behind the newest one and still go on: one whose knobs needed no second turn began earlier."""
MAY_WIN = 0.1
"""Of the changes of one knob, the share that may beat a track."""
STEPS = 0.5
"""Of what is known of a run of a ladder, all that its process took, the share of the steps: the rest is judging them."""
RARELY = 0.25
"""The chance that ladders go on beyond their finest step, and that starts follow: few motions are not to be foreseen."""


@dataclass(frozen=True, slots=True)
class ToCome:
    """Trials like this one that will be asked for.

    Terms: answers, clocks: how many, in expectation. run [s]: of its steps, the mean of those known, 0 where none is.
    at_once: how many of the answers at a time; the next follow from theirs.
    """

    like: Trial
    answers: float
    clocks: float = 0.0
    run: float = 0.0
    at_once: int = 1


def seconds_of_run(trial: Trial, record: Record, case: Case) -> float:
    """What the steps of a run take, of CPU time and roughly; 0 where that is not known or what is clocked is no step."""
    share = 1.0 if trial.experiment.refine is None else STEPS
    return share * _cost(record, case) if case.rays is None else 0.0


def _cost(record: Record, case: Case) -> float:
    return (record.rough_cost or 0.0) * case.duration


def to_come(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> list[ToCome]:
    """Beyond these trials, of which those without a record are being answered."""
    return [
        *_of_limits([trial for trial in trials if trial.experiment.limit is not None], records, cases, adapters),
        *_of_sweeps(trials, records, cases, adapters),
        *_of_dominance([trial for trial in trials if trial.experiment.dominance], records, cases, adapters),
        *_of_ladders([trial for trial in trials if trial.experiment.refine is not None], records, cases),
    ]


@dataclass(frozen=True, slots=True)
class _Chances:
    """Shares: of a value that is tried and breaks, of a remedy that helps."""

    breaks: float
    helps: float


def _of_limits(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> Iterator[ToCome]:
    groups = first_break.searches_of(trials, cases)
    chances = _chances(trials, records)
    sick = {trial.remedied for trial in trials if trial.remedied}
    for group in groups:
        first, by = group[0], first_break.ruler(group[0], cases[group[0].case])
        limit = first.experiment.limit
        known: dict[float, str | None] = {}
        for trial in group:
            record = records.get(trial.trial)
            known[first_break.value_of(trial, by.axis)] = None if record is None else record.status
        if limit is None:
            continue
        if first.remedied:
            yield ToCome(first, _beyond(known, by, chances))
            continue
        answers, broke = _along(known, by, limit.scan, chances)
        yield ToCome(group[-1], answers)
        tried = any(trial.trial in sick for trial in group)
        if first.track in limit.remedies and broke > 0 and not tried:
            count = sum(1 for _ in remedied(first, cases[first.case], adapters[first.engine], 1))
            asked = broke * count * (1 + chances.helps * (first_break.REMEDY_VALUES - 1))
            yield ToCome(group[-1], asked, at_once=max(1, count))


def _chances(trials: Sequence[Trial], records: Mapping[str, Record]) -> _Chances:
    """By what was tried, with one of each kind that nobody saw."""
    scanned = [records[t.trial].status for t in trials if t.trial in records and not t.remedied]
    mended = [records[t.trial].status for t in trials if t.trial in records and t.remedied]
    broke = sum(status in first_break.BROKE for status in scanned)
    return _Chances(
        breaks=(broke + 1) / (len(scanned) + 2), helps=(sum(status == "passed" for status in mended) + 1) / (len(mended) + 2)
    )


def _along(known: Mapping[float, str | None], by: first_break.Ruler, scan: int, chances: _Chances) -> tuple[float, float]:
    """Answers that a search will still ask for, and the chance that it ends at a value that broke."""
    waiting = next((value for value, status in known.items() if status is None), None)
    if waiting is not None:
        return _either(known, waiting, by, scan, chances)
    settled = {value: status for value, status in known.items() if status is not None}
    value = first_break.next_value(settled, by, scan)
    interval = first_break.bracket(settled, by)
    if value is None:
        return 0.0, float(interval.broke is not None)
    if interval.broke is not None:
        # A bracket is halved as often whichever half is left.
        answers, broke = _along({**known, value: "failed"}, by, scan, chances)
    else:
        answers, broke = _either(known, value, by, scan, chances)
    return 1 + answers, broke


def _either(
    known: Mapping[float, str | None], value: float, by: first_break.Ruler, scan: int, chances: _Chances
) -> tuple[float, float]:
    fails, holds = (_along({**known, value: status}, by, scan, chances) for status in ("failed", "passed"))
    share = chances.breaks
    return share * fails[0] + (1 - share) * holds[0], share * fails[1] + (1 - share) * holds[1]


def _beyond(known: Mapping[float, str | None], by: first_break.Ruler, chances: _Chances) -> float:
    """Answers to come of a remedy: where it helps, the next values until its bracket is a quarter."""
    left = first_break.REMEDY_VALUES + 1 - len(known)
    if None in known.values():
        return chances.helps * max(0, left) if len(known) == 1 else float(max(0, left))
    settled = {value: status for value, status in known.items() if status is not None}
    return float(max(0, left)) if first_break.beyond(settled, by) is not None else 0.0


def _of_sweeps(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> Iterator[ToCome]:
    groups = list(front.groups(trials))
    spent = [(front.room_in(group, records), sum(trial.round > front.SCREENING for trial in group)) for group in groups]
    points = sum(group[0].experiment.sweep - room for group, (room, late) in zip(groups, spent, strict=True) if late)
    pace = (sum(late for _, late in spent) + 1) / (points + 1)
    newest = max((trial.round for group in groups for trial in group), default=0)
    for group, (room, late) in zip(groups, spent, strict=True):
        first = group[0]
        rounds = max(trial.round for trial in group)
        answers = min(max(0, room) * pace, front.RUNS * first.experiment.sweep - late)
        if rounds > front.SCREENING:
            answers = min(answers, _still_found(sum(trial.round == rounds for trial in group)))
        if newest > front.SCREENING and rounds < newest - BEHIND:
            answers = 0.0
        if rounds < front.SCREENING:
            answers += len(adapters[first.engine].knobs_in(first.scene(cases[first.case]))) * (front.SCREENING - rounds) / 2
        clocks = min(front.CLOCKED, len(group) + answers) if first.experiment.timing else 0
        runs = [seconds_of_run(trial, records[trial.trial], cases[trial.case]) for trial in group if trial.trial in records]
        run = fmean(runs) if runs else 0.0
        like = min(group, key=lambda trial: abs(trial.settings.dt - cases[trial.case].dt))
        yield ToCome(like, answers, clocks, run, front.PER_ROUND)


def _of_dominance(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> Iterator[ToCome]:
    newest = max((trial.round for trial in trials), default=0)
    for trial in trials:
        if trial.round == 0 and trial.experiment.dominance:
            record, case = records.get(trial.trial), cases[trial.case]
            count = len(changes := dominance.changes_of(trial, record, case, adapters[trial.engine])) + bool(changes)
            run = 0.0 if record is None else seconds_of_run(trial, record, case)
            better = MAY_WIN * count
            drawn = len(dominance.FACTORS) * (better + min(better, 1.0)) if newest < 2 else 0.0
            clocks = (better + min(better, 1.0)) * (1 + len(dominance.FACTORS))
            if newest == 0:
                yield ToCome(trial, count, run=run, at_once=max(1, count))
            yield ToCome(trial, drawn, clocks, run, max(1, round(drawn)))


def _still_found(last: int) -> float:
    """Answers that a sweep asks for at most: one that found less to try than a round may hold runs dry, by half each round."""
    return math.inf if last >= front.PER_ROUND else 2.0 * last


def _of_ladders(trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case]) -> Iterator[ToCome]:
    ladders: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.alteration == AS_IT_IS:
            side = (trial.experiment.name, trial.case, dict(trial.parameters), trial.seed, trial.engine, trial.track)
            ladders.setdefault(repr(side), []).append(trial)
    begun = any(trial.alteration.start for trial in trials)
    newest = max((trial.round for trial in trials), default=0)
    for ladder in ladders.values():
        asked, case = ladder[0].experiment.refine, cases[ladder[0].case]
        last = min(ladder, key=lambda trial: trial.settings.dt)
        assert asked is not None
        over = begun or (last.trial in records and last.round < newest)
        costs = {trial.trial: _cost(records[trial.trial], case) for trial in ladder if trial.trial in records}
        share, spent = asked.budget / len(ladders), sum(costs.values())
        known = min((trial for trial in ladder if costs.get(trial.trial)), key=lambda trial: trial.settings.dt, default=None)
        a_step = 0.0 if known is None else costs[known.trial] * known.settings.dt
        spent += sum(a_step / trial.settings.dt for trial in ladder if trial.trial not in records)
        dt, coarsest = last.settings.dt / 2, asked.finest / 2**asked.further
        while not over and dt > coarsest * (1 - 1e-9) and spent + a_step / dt <= share:
            chance = 1.0 if dt > asked.finest * (1 - 1e-9) else RARELY
            clocks = chance if last.experiment.timing else 0.0
            yield ToCome(replace(last, settings=last.settings.with_dt(dt)), chance, clocks, STEPS * a_step / dt)
            spent, dt = spent + chance * a_step / dt, dt / 2
        if asked.members and not begun and known is not None:
            near = min(ladder, key=lambda trial: abs(trial.settings.dt - asked.member_dt))
            yield ToCome(near, RARELY * asked.members, at_once=max(1, asked.members))
