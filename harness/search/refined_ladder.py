"""How a ladder of time steps goes on: halved until each engine's limit is known, then ensembles of starts where it cannot be.

Every engine and track of a scene is run at the steps that the experiment names, then at half the last one, down to a finest.
Beyond that it goes on for a few halvings more where its limit is not known to the end of the run: an engine that leaves the
numbers at coarse steps, or whose answers draw together slowly, is given the steps that it needs. All share a budget of CPU
time alike: a ladder ends before the step that would, by the cost of the one before, take more than its share. A run costs what
its process took from an engine that is ready to a judged answer.

Where fewer than two engines that people can deploy have a limit up to the end, motion is not to be foreseen, by chaos or
contacts, and single runs say little of it. There each engine is run from several perturbed starts at one step, so that means
can be compared.

Where an engine's two tracks end apart, or it ends apart from others, its settings are turned one by one, to see which one does
it (`harness.search.refined_ladder`).

Where a robot's user left out what not every engine has (`--drop`), each engine is also run once with it, at the finest step
that it answered: what the omission does is a number then. Such a run counts for nothing else.

Which setting makes an engine's track end elsewhere: each is turned alone, and the run that comes nearest tells.

An engine is asked where its two tracks end apart by more than their bars and what is granted: the settings of `default` are
turned to those of `tuned` one by one, at one step that both have answered. Where the tracks end alike and apart from two others
that end alike, the knobs of `tuned` are turned. The likeliest come first: those called like an effect that the engine adds,
then like a law of the scene, then those that act on what it has, then the others; as many as the experiment allows and the
engine's share of the budget pays for.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import AS_IT_IS, TURNED, UNDROPPED, Alteration
from plumbline.harness.case.undropped import kinds_left_out
from plumbline.harness.scene import Effect, Scene
from plumbline.harness.search.own_limits import ANSWERED, FEWEST, TOLERANCE, OwnLimit, granted_of, own_limit, rungs_of
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.foreseen_cost import too_many_steps
from plumbline.harness.study.one_knob import KnobTurn, differing, label_of, turned, turns
from plumbline.harness.study.trial import Trial, question_of
from plumbline.harness.trajectory.parting import Extent, apart, common, extent

_GENERAL = Effect.GRAVITY | Effect.CONTACT | Effect.JOINTS | Effect.DRIVES | Effect.SENSING
"""What nearly every setting is about."""
Side = tuple[str, str]
"""Engine and track."""


def turned_trials(
    ladders: Mapping[Side, Sequence[Trial]],
    limits: Mapping[Side, OwnLimit],
    records: Mapping[str, Record],
    case: Case,
    adapters: Mapping[str, Adapter],
    scale: Extent,
    *,
    near: float,
    most: int,
    affordable: Mapping[Side, float],
    number: int,
) -> Iterator[Trial]:
    """The runs of one setting turned each. Args: near [s]: the step that is asked for. affordable [s]: CPU time by side."""
    for engine in dict.fromkeys(engine for engine, _ in ladders):
        track = _questioned(engine, limits, case.scene(case.at(**next(iter(ladders.values()))[0].parameters)), scale)
        if track is None:
            continue
        base = _at(ladders[engine, track], records, near)
        target = _at(ladders.get((engine, "tuned"), ()), records, near)
        if base is None or target is None or (track == "default" and base.settings.dt != target.settings.dt):
            continue
        cost = (records[base.trial].rough_cost or 0.0) * case.duration
        count = most if cost <= 0 else min(most, int(affordable[engine, track] / cost))
        likely = candidates(base, target, records[base.trial], case, adapters[engine])
        for turn in islice(likely, count):
            yield base.probing(
                case,
                track=label_of(track, [(turn.name, turn.value)]),
                base=track,
                settings=turned(base.settings, turn.knob, turn.value),
                alteration=Alteration(name=TURNED),
                round=number,
            )


def _questioned(engine: str, limits: Mapping[Side, OwnLimit], scene: Scene, scale: Extent) -> str | None:
    """The track whose settings are turned; None where nothing is to be explained."""
    default, tuned = limits.get((engine, "default")), limits.get((engine, "tuned"))
    if default is not None and tuned is not None and _part(default, tuned, scene, scale):
        return "default"
    others = [limit for (name, track), limit in limits.items() if name != engine and track == "tuned" and limit.finest]
    if tuned is None or len(others) < 2 or not all(_part(tuned, other, scene, scale) for other in others):
        return None
    return "tuned" if any(not _part(a, b, scene, scale) for k, a in enumerate(others) for b in others[:k]) else None


def _part(first: OwnLimit, second: OwnLimit, scene: Scene, scale: Extent) -> bool:
    """Do two end apart: their limits by more than both bars and what is granted, else their finest runs by the tolerance?"""
    if first.value is not None and second.value is not None and min(first.seen_until, second.seen_until) > 0:
        until = min(first.seen_until, second.seen_until)
        first_cut, second_cut = common([first.value.between(0.0, until), second.value.between(0.0, until)])
        granted = granted_of(scene, scale, touching=Effect.CONTACT in scene.effects)
        allowed = first.bar_at(until) + second.bar_at(until) + granted
    else:
        runs = [rung.run for limit in (first, second) if (rung := limit.finest) is not None and rung.run is not None]
        if len(runs) < 2:
            return False
        first_cut, second_cut = common(runs)
        allowed = TOLERANCE
    return float(apart(first_cut, second_cut, scale).max(initial=0.0)) > allowed


def _at(ladder: Sequence[Trial], records: Mapping[str, Record], near: float) -> Trial | None:
    """The run of a ladder that has an answer and whose step is nearest to one [s]."""
    answered = [trial for trial in ladder if trial.trial in records and records[trial.trial].status in ANSWERED]
    return min(answered, key=lambda trial: abs(trial.settings.dt - near), default=None)


def candidates(base: Trial, target: Trial, record: Record, case: Case, adapter: Adapter) -> list[KnobTurn]:
    """The turns of one setting, the likeliest first: to where the other track has it, or of a knob where there is none."""
    scene = base.scene(case)
    meant = adapter.knobs_in(scene)
    every = differing(base.settings, target.settings) or list(turns(base.settings, meant, adapter.knobs))
    first: dict[tuple[str, object], KnobTurn] = {}
    for turn in every:
        if turn.knob not in adapter.knobs or turn.knob in meant:
            first.setdefault((turn.knob, turn.value), turn)
    added = [notice.effect for notice in record.warnings if notice.kind == "surplus" and notice.effect]

    def like(turn: KnobTurn, effects: Iterable[str]) -> bool:
        return any(turn.name in effect or effect in turn.name for effect in effects)

    def rank(turn: KnobTurn) -> tuple[bool, bool, bool, bool]:
        unlike = not like(turn, added), not like(turn, (scene.effects & ~_GENERAL).names)
        return *unlike, turn.knob not in adapter.acts_on, turn.knob not in adapter.knobs

    return sorted(first.values(), key=rank)


RESERVED = 1 / 3
"""Of a side's share of the budget, what perturbed starts may take where its ladder has left less."""
_UNKNOWN = 1e-9
"""Relative: a time that is so near the end is the end."""


def is_ours(adapter: Adapter) -> bool:
    """Is it the engine of this project, whose word settles nothing?"""
    return adapter.distribution == "plumbline"


def start_name(number: int) -> str:
    """What the run of a perturbed start is called."""
    return f"start {number}"


def next_trials(
    trials: Sequence[Trial],
    records: Mapping[str, Record],
    cases: Mapping[str, Case],
    adapters: Mapping[str, Adapter],
    *,
    store: Store,
    wanted: Callable[[Trial], bool] = lambda _: True,
) -> list[Trial]:
    """The next round of all ladders; empty where each has ended. Args: wanted: is there time for a finer step? Where there is
    none its ladder has ended."""
    scenes: dict[str, list[Trial]] = {}
    for trial in trials:
        if trial.experiment.refine is not None:
            name = (trial.experiment.name, trial.case, dict(trial.parameters), trial.seed)
            scenes.setdefault(repr(name), []).append(trial)
    probes = []
    for scene in scenes.values():
        refinement = scene[0].experiment.refine
        assert refinement is not None
        probes += list(_of_scene(scene, refinement, records, cases[scene[0].case], adapters, store, wanted))
    return probes


def _of_scene(
    scene: Sequence[Trial],
    refinement: Refinement,
    records: Mapping[str, Record],
    case: Case,
    adapters: Mapping[str, Adapter],
    store: Store,
    wanted: Callable[[Trial], bool],
) -> Iterator[Trial]:
    ladders: dict[tuple[str, str], list[Trial]] = {}
    for trial in scene:
        if trial.alteration == AS_IT_IS:
            ladders.setdefault((trial.engine, trial.track), []).append(trial)
    whole, share = case.scene(case.at(**scene[0].parameters)), refinement.budget / len(ladders)
    scale = extent(whole)
    granted = granted_of(whole, scale, touching=Effect.CONTACT in whole.effects)
    number = max(trial.round for trial in scene) + 1
    limits = {side: _limit(ladder, records, scale, store, adapters[side[0]], granted) for side, ladder in ladders.items()}
    turned = {trial.engine for trial in scene if trial.alteration.name == TURNED}
    yield from turned_trials(
        {side: ladder for side, ladder in ladders.items() if side[0] not in turned},
        limits, records, case, adapters, scale,
        near=refinement.member_dt,
        most=refinement.turns,
        affordable={side: max(share - _spent(ladder, records, case), RESERVED * share) for side, ladder in ladders.items()},
        number=number,
    )  # fmt: skip
    more = [
        finer
        for side, ladder in ladders.items()
        if (finer := _halved(ladder, limits[side], refinement, records, case, share, number)) is not None and wanted(finer)
    ]
    if more:
        yield from more
        return
    if case.undropped is not None and not any(trial.alteration.undropped for trial in scene):
        yield from _undropped(ladders, records, case, number)
    if any(trial.alteration.start for trial in scene) or not refinement.members:
        return
    # An engine's tuned answer counts, where it has one: what a vendor's default adds may well calm a motion that is chaotic.
    counted = {engine: limit for (engine, track), limit in limits.items() if track != "tuned" and _answered(limit)}
    counted |= {engine: limit for (engine, track), limit in limits.items() if track == "tuned" and _answered(limit)}
    settled = [engine for engine, limit in counted.items() if _to_the_end(limit, case) and not is_ours(adapters[engine])]
    if len(settled) < 2:
        for side, ladder in ladders.items():
            if len(_answered(limits[side])) >= FEWEST:
                yield from _starts(ladder, refinement, records, case, share, number)


def _limit(
    ladder: Sequence[Trial],
    records: Mapping[str, Record],
    scale: Extent,
    store: Store,
    adapter: Adapter,
    granted: float,
) -> OwnLimit:
    answered = [records[trial.trial] for trial in ladder if trial.trial in records]
    return own_limit(scale, rungs_of(store, answered), adapter.orders, granted)


def _answered(limit: OwnLimit) -> list[float]:
    return [rung.dt for rung in limit.rungs if rung.status in ANSWERED]


def _to_the_end(limit: OwnLimit, case: Case) -> bool:
    return limit.until >= case.duration * (1 - _UNKNOWN) - case.sample_interval


def _halved(
    ladder: Sequence[Trial],
    limit: OwnLimit,
    refinement: Refinement,
    records: Mapping[str, Record],
    case: Case,
    share: float,
    number: int,
) -> Trial | None:
    """The ladder's next step; None where it ends."""
    last = min(ladder, key=lambda trial: trial.settings.dt)
    record = records.get(last.trial)
    if record is None or record.status not in (*ANSWERED, "diverged"):
        return None
    finer = last.settings.dt / 2
    beyond = finer < refinement.finest * (1 - _UNKNOWN)
    if beyond and (_to_the_end(limit, case) or finer < refinement.finest / 2**refinement.further * (1 - _UNKNOWN)):
        return None
    if too_many_steps(case.duration, finer) or _spent(ladder, records, case) + 2 * _cost(record, case) > share:
        return None
    return last.probing(case, settings=last.settings.with_dt(finer), round=number)


def _undropped(
    ladders: Mapping[tuple[str, str], Sequence[Trial]], records: Mapping[str, Record], case: Case, number: int
) -> Iterator[Trial]:
    """Each engine with what the user left out, at the finest step that it answered without, tuned where it answered so."""
    assert case.undropped is not None
    finest: dict[str, Trial] = {}
    for (engine, _), ladder in sorted(ladders.items(), key=lambda item: item[0][1] != "tuned"):
        answered = [trial for trial in ladder if trial.trial in records and records[trial.trial].status in ANSWERED]
        if answered:
            finest.setdefault(engine, min(answered, key=lambda trial: trial.settings.dt))
    for trial in finest.values():
        kinds = kinds_left_out(case.scene(case.at(**trial.parameters)), case.undropped)
        yield trial.probing(
            case,
            alteration=Alteration(name=UNDROPPED, undropped=kinds),
            question=question_of(case, trial.parameters, case.undropped),
            round=number,
        )


def _starts(
    ladder: Sequence[Trial], refinement: Refinement, records: Mapping[str, Record], case: Case, share: float, number: int
) -> Iterator[Trial]:
    """An engine from perturbed starts, at the step that was asked for or the next one that it answered and can pay for.

    They are paid for by what its ladder has left of its share, or by as much as RESERVED of it beyond.
    """
    answered = [trial for trial in ladder if records[trial.trial].status in ANSWERED]
    near = sorted(answered, key=lambda trial: abs(trial.settings.dt - refinement.member_dt))
    affordable = max(share - _spent(ladder, records, case), RESERVED * share)
    for trial in near:
        if refinement.members * _cost(records[trial.trial], case) <= affordable:
            for start in range(1, refinement.members + 1):
                yield trial.probing(case, alteration=Alteration(name=start_name(start), start=start), round=number)
            return


def _spent(ladder: Sequence[Trial], records: Mapping[str, Record], case: Case) -> float:
    """CPU seconds of the runs of a ladder."""
    return sum(_cost(records[trial.trial], case) for trial in ladder if trial.trial in records)


def _cost(record: Record, case: Case) -> float:
    """CPU seconds of a run, roughly; nothing of one that gave no answer."""
    return (record.rough_cost or 0.0) * case.duration
