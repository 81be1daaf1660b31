"""Which settings to try for work-precision: a coarse design, then steps along the Pareto front, as many for every engine.

For a case on an engine the tracks come first, at each time step of the ladder. Then every knob that the adapter declares for
such a scene is turned once; one that leaves the error nearly as it was is turned once more at the finest step, since a slop
or a tolerance may be felt there alone, unless it moved the answer by rounding only. One that leaves the trajectory as it was,
bit for bit, or that the adapter refuses, at both, means nothing here and is left alone. From then on each point of the front
tries its neighbours: twice and half its time step, and the next value to both sides of every knob that matters, those first
that moved the error most. Where a round brings nothing to the front, exact answers on it are tried at twice their step, then
the neighbours of what lies next behind it: an engine whose front stays early is given as many points as one whose front goes
on. That ends when the experiment's number of points is spent, or nothing is left to try; knobs that mean nothing here are not
counted.

Costs are rough: each is clocked beside its accuracy run, in turns with a yardstick, the default track at the case's own step,
and what is compared are the ratios. They say nothing about differences of a few per cent; what they leave near the front is
clocked properly afterwards.
"""

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from statistics import median
from typing import Any

import numpy as np

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.case import Case
from plumbline.harness.statistics.pareto import near_front
from plumbline.harness.store.record import Record
from plumbline.harness.study.one_knob import OPTION, key_of, label_of, position, turned
from plumbline.harness.study.trial import Trial

SMALLEST = 1e-8
"""Share of a case's scale below which a smaller error counts as no better."""
TELLING = 1.2
"""Rough costs tell two points apart where one is larger than the other by more than this; otherwise the earlier one counts.

Each was off by some 5 % between two runs, one of them under load, so the ratio of two by 7 %: nearly three times that."""
PER_ROUND = 4
"""New points of a case on an engine in a round, so that later ones profit from what the first have shown."""
SCREENING = 2
"""The rounds in which knobs are turned once, at the case's own step and at the finest; the points that a study
gives come after them, so that an engine with many knobs has as many left."""
RUNS = 2
"""Runs that a search may take for each of its points: some settings give the answer of others."""
LONGEST = 4.0
"""A run that is foreseen to take more CPU seconds than this is not tried; one whose knob is turned is foreseen to take as long
as before."""
BEYOND = 4.0
"""How far beyond both ends of a case's ladder the time step may go."""
MARGIN = 1.5
"""A point is clocked unless another that errs no more seems cheaper by more than this."""
CLOCKED = 12
"""Points of an engine that are chosen for the clock at most; those of the front come first, spread over its errors."""


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """A trial with its error as a share of the scale and its rough cost, in CPU seconds per simulated second or unit.

    Costs of a group are multiples of the same yardstick, wherever one could be clocked: of its middle cost.
    """

    trial: Trial
    record: Record
    error: float
    cost: float


Group = Sequence[Trial]
"""The trials of one case, at one set of parameters, on one engine."""


def groups(trials: Sequence[Trial]) -> Iterator[list[Trial]]:
    """The trials of sweeping experiments, one list a case and engine."""

    def key(trial: Trial) -> tuple[str, ...]:
        return trial.experiment.name, trial.case, repr(trial.parameters), trial.engine

    for _, group in groupby(sorted((t for t in trials if t.experiment.sweep), key=key), key=key):
        yield list(group)


def points(group: Group, records: Mapping[str, Record], case: Case) -> list[FrontPoint]:
    """What of a group has a finite error and a cost."""
    measured: list[FrontPoint] = []
    yardsticks = [r.rough_cost / r.rough_ratio for t in group if (r := records.get(t.trial)) and r.rough_cost and r.rough_ratio]
    yardstick = median(yardsticks) if yardsticks else 1.0
    if any(metric.better == "higher" for metric in case.metrics if metric.name == case.headline):
        return measured
    for trial in group:
        record = records.get(trial.trial)
        if record is None or record.status not in ("passed", "failed") or not record.rough_cost:
            continue
        error = next((abs(m.value) for m in record.measurements if m.metric == case.headline), float("nan")) / case.scale
        if error < float("inf"):
            cost = record.rough_cost if record.rough_ratio is None else record.rough_ratio * yardstick
            measured.append(FrontPoint(trial, record, max(error, SMALLEST), cost))
    return _smoothed(measured) if case.unit(group[0].parameters) == "step" else measured


def _smoothed(here: Sequence[FrontPoint]) -> list[FrontPoint]:
    """The points, coarser steps first, with costs that fall as the step of the same settings grows.

    A rough cost is a few milliseconds' work. That a coarser step costs no more for a second
    of simulated time is known beforehand; what contradicts it is levelled.

    Source: R. E. Barlow, D. J. Bartholomew, J. M. Bremner, H. D. Brunk, Statistical Inference under Order Restrictions (1972).
    """
    from scipy.optimize import isotonic_regression  # late: a listing must not pay for it

    families: dict[Hashable, list[FrontPoint]] = {}
    for point in sorted(here, key=lambda point: -point.trial.settings.dt):
        families.setdefault(_family(point), []).append(point)
    level: list[FrontPoint] = []
    for family in families.values():
        costs = np.exp(isotonic_regression(np.log([point.cost for point in family])).x)
        level += [replace(point, cost=float(cost)) for point, cost in zip(family, costs, strict=True)]
    return sorted(level, key=lambda point: -point.trial.settings.dt)


def next_trials(
    trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case], adapters: Mapping[str, Adapter]
) -> list[Trial]:
    """The next round over all cases and engines; empty when all points are spent, or nothing is left to try."""
    probes: list[Trial] = []
    for group in groups(trials):
        probes += _next_of_group(group, records, cases[group[0].case], adapters[group[0].engine])
    return probes


def _next_of_group(group: Group, records: Mapping[str, Record], case: Case, adapter: Adapter) -> list[Trial]:
    here = points(group, records, case)
    if not here:
        return []
    last = max(trial.round for trial in group)
    base = _base(here, case)
    room = room_in(group, records)
    if room <= 0 or sum(trial.round > SCREENING for trial in group) >= RUNS * group[0].experiment.sweep:
        return []
    knobs = adapter.knobs_in(group[0].scene(case))
    felt = _felt(group, records, here, knobs)
    tried = {key_of(trial.settings) for trial in group}
    wanted = list(_screening(base, knobs, adapter)) if last == 0 else []
    if last == 1 and (finest := _finest(here, case)) is not None:
        wanted = list(_screening(finest, [knob for knob in knobs if knob not in felt or felt[knob].worth_another], adapter))
    screens = any(key_of(settings) not in tried for _, settings in wanted)
    probes: list[Trial] = []
    limit = len(wanted) if screens else min(room, PER_ROUND)
    number = last + 1 if screens else max(last, SCREENING) + 1
    for origin, settings in wanted if screens else _around(here, felt, case, adapter, last):
        if (key := key_of(settings)) not in tried:
            tried.add(key)
            ancestor = origin.base or origin.track
            track = _label(ancestor, settings, adapter)
            probes.append(origin.probing(case, track=track, base=ancestor, settings=settings, round=number))
            if len(probes) == limit:
                break
    return probes


def _base(here: Sequence[FrontPoint], case: Case) -> FrontPoint:
    """The point that knobs are first turned at: 'tuned' where it stands, at the step next to the case's own."""
    first = [point for point in here if point.trial.round == 0]
    tuned = [point for point in first if point.trial.track == "tuned"]
    return min(tuned or first or here, key=lambda point: abs(point.trial.settings.dt / case.dt - 1))


def _finest(here: Sequence[FrontPoint], case: Case) -> FrontPoint | None:
    """The first point at the finest step of those that may be tried again in time: 'tuned' where it stands."""
    first = [
        point for point in here if point.trial.round == 0 and point.cost * case.put(point.trial.parameters).duration < LONGEST
    ]
    return min(first, key=lambda point: (point.trial.settings.dt, point.trial.track != "tuned"), default=None)


def _family(point: FrontPoint) -> Hashable:
    """What points share that differ in the time step alone."""
    return key_of(point.trial.settings, "dt")


def _label(base: str, settings: Settings, adapter: Adapter) -> str:
    """The track that a point descends from, and all knobs that stand elsewhere now."""
    own = adapter.tracks[base]
    changed = [knob for knob in adapter.knobs if position(settings, knob) != position(own, knob)]
    return label_of(base, ((knob.removeprefix(OPTION), position(settings, knob)) for knob in changed))


def _screening(base: FrontPoint, knobs: Iterable[str], adapter: Adapter) -> Iterator[tuple[Trial, Settings]]:
    """Each of these knobs, turned once."""
    for knob in knobs:
        for value in _beside(base, knob, adapter)[:1]:
            yield base.trial, turned(base.trial.settings, knob, value)


def _beside(point: FrontPoint, knob: str, adapter: Adapter) -> list[Any]:
    """The values next to where a knob stands; the ends of its range where it stands at none of them.

    Those that are known to change nothing at that point are passed over.
    """
    now = position(point.trial.settings, knob)
    if now is None:
        now = position(Settings(**point.record.resolved), knob) if point.record.resolved else None
    values = [value for value in adapter.knobs[knob] if value == now or (knob, value) not in point.record.idle]
    if now in values:
        index = values.index(now)
        return [values[k] for k in (index + 1, index - 1) if 0 <= k < len(values)]
    return [value for value in dict.fromkeys((*values[:1], *values[-1:])) if value != now]


@dataclass(frozen=True, slots=True)
class Felt:
    """What turning a knob did to the error at most: the ratio of two errors, and their difference as a share of the scale."""

    ratio: float
    shift: float

    @property
    def worth_another(self) -> bool:
        """Is it worth another turn at the finest step: moved the error, but not by much?"""
        return self.shift > SMALLEST and self.ratio < TELLING


def _felt(group: Group, records: Mapping[str, Record], here: Sequence[FrontPoint], knobs: Iterable[str]) -> dict[str, Felt]:
    """The knobs that changed a trajectory: two runs whose settings differ in the knob alone gave two answers.

    Returns: by knob, what it did; a ratio of 1 and an infinite shift where no two of them have an error.
    """
    errors = {point.trial.trial: point.error for point in here}
    felt = {}
    for knob in knobs:
        answers: dict[Hashable, dict[str, str]] = {}
        for trial in group:
            record = records.get(trial.trial)
            if record is not None and record.trajectory_hash is not None:
                answers.setdefault(key_of(trial.settings, knob), {})[record.trajectory_hash] = trial.trial
        unlike = [runs.values() for runs in answers.values() if len(runs) > 1]
        if unlike:
            pairs = [some for names in unlike if (some := [errors[name] for name in names if name in errors])]
            felt[knob] = Felt(
                ratio=max((max(some) / min(some) for some in pairs), default=1.0),
                shift=max((max(some) - min(some) for some in pairs), default=math.inf),
            )
    return felt


def _front(here: Sequence[FrontPoint]) -> list[FrontPoint]:
    """The points of the front, the cheapest first, so found that noise in rough costs leads the search as little as may be.

    Of the same settings a coarser step costs less, whatever the rough costs say. Otherwise a point counts where it errs less
    than every one before it that is not dearer by more than rough costs tell.
    """
    least: dict[Hashable, float] = {}
    candidates: list[FrontPoint] = []
    for point in sorted(here, key=lambda point: -point.trial.settings.dt):
        family = _family(point)
        if point.error < least.get(family, math.inf):
            least[family] = point.error
            candidates.append(point)
    front: list[FrontPoint] = []
    for point in sorted(candidates, key=lambda point: point.trial.round):
        if not any(old.error <= point.error and old.cost < TELLING * point.cost for old in front):
            front = [old for old in front if old.error < point.error or old.cost * TELLING < point.cost] + [point]
    return sorted(front, key=lambda point: (point.cost, -point.error))


def _coarser_still(here: Sequence[FrontPoint], case: Case) -> Iterator[tuple[Trial, Settings]]:
    """Twice the step of what has no error to speak of: that costs less without being worse, however little less."""
    for point in _front(here):
        dt = 2 * point.trial.settings.dt
        if point.error <= SMALLEST and dt <= BEYOND * max(case.ladder) * (1 + 1e-9):
            yield point.trial, point.trial.settings.with_dt(dt)


def room_in(group: Group, records: Mapping[str, Record]) -> int:
    """How many points the experiment still leaves to a group."""
    return group[0].experiment.sweep - _others(group, records)


def _others(group: Group, records: Mapping[str, Record]) -> int:
    """How many answers were found beyond those of design and screening: what leaves every bit as it was is no other answer."""
    answers = [(trial.round, records[trial.trial].trajectory_hash) for trial in group if trial.trial in records]
    first = {answer for number, answer in answers if number <= SCREENING}
    return len({answer for number, answer in answers if number > SCREENING} - first - {None})


def _apart(here: Sequence[FrontPoint]) -> list[FrontPoint]:
    """Of points with one and the same answer the earliest alone."""
    earliest: dict[object, FrontPoint] = {}
    for point in sorted(here, key=lambda point: point.trial.round):
        earliest.setdefault(point.record.trajectory_hash or point.trial.trial, point)
    return list(earliest.values())


def _layers(here: Sequence[FrontPoint]) -> Iterator[list[FrontPoint]]:
    """The front, then that of what is left without it, and so on."""
    left = list(here)
    while left:
        front = _front(left)
        yield front
        left = [point for point in left if point not in front]


def _around(
    here: Sequence[FrontPoint], felt: Mapping[str, Felt], case: Case, adapter: Adapter, last: int
) -> Iterator[tuple[Trial, Settings]]:
    """Lazy generator of the neighbours of the front, then of those of the next front behind it."""
    if last > SCREENING and not any(point.trial.round == last for point in _front(here)):
        yield from _coarser_still(here, case)
    foremost = sorted(felt, key=lambda knob: -felt[knob].ratio)
    for layer in _layers(_apart(here)):
        yield from _neighbours(layer, foremost, case, adapter)


def _neighbours(
    front: Sequence[FrontPoint], live: Sequence[str], case: Case, adapter: Adapter
) -> Iterator[tuple[Trial, Settings]]:
    """Around each point of a front, in turn: the time step first, then knob after knob."""
    coarsest, finest = BEYOND * max(case.ladder), min(case.ladder) / BEYOND
    moves: list[list[tuple[Trial, Settings]]] = []
    for point in front:
        settings, taken = point.trial.settings, point.cost * case.put(point.trial.parameters).duration
        near: list[tuple[Trial, Settings]] = []
        for dt in (settings.dt * 2, settings.dt / 2):
            if finest * (1 - 1e-9) <= dt <= coarsest * (1 + 1e-9) and taken * settings.dt / dt < LONGEST:
                near.append((point.trial, settings.with_dt(dt)))
        if taken < LONGEST:
            near += [(point.trial, turned(settings, knob, value)) for knob in live for value in _beside(point, knob, adapter)]
        moves.append(near)
    for turn in range(max((len(near) for near in moves), default=0)):
        yield from (near[turn] for near in moves if turn < len(near))


def due_for_clock(trials: Sequence[Trial], records: Mapping[str, Record], cases: Mapping[str, Case]) -> set[str]:
    """The swept trials that are clocked: those near the front, with the coarser step that a price is interpolated towards, and
    both tracks at the case's own time step."""
    due: set[str] = set()
    for group in groups(trials):
        case = cases[group[0].case]
        here = points(group, records, case)
        near = near_front([p.error for p in here], [p.cost for p in here], MARGIN)
        ranked = spread(_front(here))
        # What moves every body alike is no other answer, but where it is clearly cheaper: on the front then.
        known = {point.record.trajectory_hash for point in ranked}
        for point in sorted((p for p, close in zip(here, near, strict=True) if close), key=lambda p: p.trial.round):
            if point.record.trajectory_hash not in known:
                known.add(point.record.trajectory_hash)
                ranked.append(point)
        chosen = ranked[:CLOCKED]
        chosen += [coarser for point in chosen if (coarser := _coarser(point, here)) is not None]
        due |= {point.trial.trial for point in chosen}
        due |= {p.trial.trial for p in here if p.trial.round == 0 and p.trial.settings.dt == case.dt}
    return due


def spread(front: Sequence[FrontPoint]) -> list[FrontPoint]:
    """The points of a front, its ends first and then always the one farthest from those before, by the error's logarithm.

    Source: T. F. Gonzalez, Clustering to minimize the maximum intercluster distance, Theor. Comput. Sci. 38 (1985) 293.
    """
    left = sorted(front, key=lambda point: point.error)
    chosen = [left.pop(end) for end in (0, -1) if left]
    while left:
        gaps = [min(abs(math.log(point.error / other.error)) for other in chosen) for point in left]
        chosen.append(left.pop(gaps.index(max(gaps))))
    return chosen


def _coarser(point: FrontPoint, here: Sequence[FrontPoint]) -> FrontPoint | None:
    """The same settings at the next coarser time step."""
    own = point.trial.settings
    same = (p for p in here if p.trial.track == point.trial.track and p.trial.settings.dt > own.dt)
    return min(same, key=lambda p: p.trial.settings.dt, default=None)
