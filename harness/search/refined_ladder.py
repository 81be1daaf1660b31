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
it (`harness.search.setting_turns`).

Where a robot's user left out what not every engine has (`--drop`), each engine is also run once with it, at the finest step
that it answered: what the omission does is a number then. Such a run counts for nothing else.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import AS_IT_IS, TURNED, UNDROPPED, Alteration
from plumbline.harness.case.undropped import kinds_left_out
from plumbline.harness.scene import Effect
from plumbline.harness.search.own_limits import ANSWERED, FEWEST, OwnLimit, granted_of, own_limit, rungs_of
from plumbline.harness.search.setting_turns import turned_trials
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Refinement
from plumbline.harness.study.foreseen_cost import too_many_steps
from plumbline.harness.study.trial import Trial, question_of
from plumbline.harness.trajectory.parting import Extent, extent

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
