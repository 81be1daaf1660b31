"""What changed of what studies find: limits whose brackets do not meet any more, determinism lost or won (repetitions that must
give the same bits, and did on one side only), and an engine that agreed with the others in a scene of one's own and does so no
more.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement, Side, Word
from plumbline.harness.findings.changes.matching import scene_of
from plumbline.harness.findings.changes.values import Change, Sense
from plumbline.harness.findings.limits_found import Search, searches
from plumbline.harness.findings.tables.determinism import Repetition, repetitions
from plumbline.harness.store.store import Store

_ANSWERED = ("limit", "beyond the extreme", "not even the easiest")


def limit_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each search whose bracket or verdict is another; brackets that share a stretch may hold the same limit."""
    return moved_limits(searches(store_a), searches(store_b))


def moved_limits(searched: Iterable[Search], searched_again: Iterable[Search]) -> Iterator[Change]:
    """The same of searches; those for remedies are left out."""
    before = {searched_by(search): search for search in searched if not search.remedied}
    for after in [search for search in searched_again if not search.remedied]:
        earlier = before.get(searched_by(after))
        if earlier is not None and (earlier.held, earlier.broke, earlier.verdict) != (after.held, after.broke, after.verdict):
            yield _moved(earlier, after)


def searched_by(search: Search) -> tuple[object, ...]:
    """What two searches have in common that look for the same limit."""
    return search.experiment, search.case, search.where, search.engine, search.track, search.parts, search.axis


def _extent(search: Search) -> tuple[float, float]:
    """From what held to what broke, counted in the direction of harder; the ends of the axis where one is missing."""
    sign = 1.0 if search.extreme > search.easy else -1.0
    held = search.easy if search.held is None else search.held
    broke = search.extreme if search.broke is None else search.broke
    if search.verdict == "not even the easiest":
        held = broke = search.easy
    if search.verdict == "beyond the extreme":
        held = broke = search.extreme
    return sign * held, sign * broke


def _sense_of_limits(before: Search, after: Search) -> Sense:
    if before.verdict not in _ANSWERED or after.verdict not in _ANSWERED:
        return "worse" if before.verdict in _ANSWERED and after.verdict == "stopped" else "neither"
    (held, broke), (holds, breaks) = _extent(before), _extent(after)
    if holds >= broke:
        return "better"
    return "worse" if breaks <= held else "within tolerance"


def _moved(before: Search, after: Search) -> Change:
    both = before.held is not None and after.held is not None and before.held > 0 and after.held > 0
    return Change(
        kind="limit",
        sense=_sense_of_limits(before, after),
        case=after.case,
        engine=after.engine,
        track=after.setting,
        where=after.where,
        dt=after.dt,
        metric=after.axis,
        unit=after.unit,
        trial_a=before.trial_broke or before.trial_held,
        trial_b=after.trial_broke or after.trial_held,
        before=before.verdict if before.held is None else before.held,
        after=after.verdict if after.held is None else after.held,
        ratio=after.held / before.held if both and before.held and after.held else None,
        detail=after.signs.brief or after.reason,
    )


_SAME, _DIFFERS = "bit-identical", "differs"


def repetition_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each. Raises: StoreError, where a trajectory is not kept any more."""
    return lost_and_won(*(repetitions_by_cell(store) for store in (store_a, store_b)))


def lost_and_won(before: Mapping[Any, Repetition], after: Mapping[Any, Repetition]) -> Iterator[Change]:
    """The same of repetitions by what was repeated."""
    for cell, now in after.items():
        then = before.get(cell)
        if then is not None and now.must and {then.verdict, now.verdict} == {_SAME, _DIFFERS}:
            yield Change(
                kind="determinism",
                sense="worse" if now.verdict == _DIFFERS else "better",
                case=now.case,
                engine=now.engine,
                track=now.track,
                metric=now.way,
                trial_a=then.trial,
                trial_b=now.trial,
                before=then.verdict,
                after=now.verdict,
                detail="" if now.first_step is None else f"from step {now.first_step} on",
            )


def repetitions_by_cell(store: Store) -> dict[tuple[Any, ...], Repetition]:
    """What repetitions gave, by what was repeated and how. Raises: StoreError."""
    parameters = dict(zip(store.trials["trial"], store.trials["parameters"], strict=True))
    return {(each.case, parameters.get(each.trial), each.engine, each.track, each.way): each for each in repetitions(store)}


_FROM_AGREEMENT: dict[Word, int] = {"agrees": 0, "converges elsewhere": 1, "does not converge": 2, "diverged": 3, "cannot": 4}
"""How far a word is from agreement. 'converges' alone is said where nothing is agreed: that is no fault of an engine."""


def own_verdict_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each engine and track of whose limit another word is said. Raises: StoreError, where trajectories are gone."""
    return changed_words(agreements(store_a), agreements(store_b))


def changed_words(agreed: Iterable[Agreement], agreed_again: Iterable[Agreement]) -> Iterator[Change]:
    """The same of agreements."""
    before = {_of_side(one, side): side for one in agreed for side in one.sides}
    for one in agreed_again:
        for side in one.sides:
            earlier = before.get(_of_side(one, side))
            if earlier is not None and earlier.word != side.word:
                yield Change(
                    kind="verdict",
                    sense=_sense_of_words(earlier.word, side.word),
                    case=one.case,
                    engine=side.engine,
                    track=side.track,
                    metric="limit",
                    before=earlier.word,
                    after=side.word,
                    detail=side.why or "judged by the limits of all engines",
                )


def _of_side(one: Agreement, side: Side) -> tuple[str, str, str, str]:
    return scene_of(one.case), one.where, side.engine, side.track


def _sense_of_words(before: Word, after: Word) -> Sense:
    if before not in _FROM_AGREEMENT or after not in _FROM_AGREEMENT:
        return "neither"
    return "worse" if _FROM_AGREEMENT[after] > _FROM_AGREEMENT[before] else "better"
