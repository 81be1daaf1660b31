"""Limits that moved: brackets of the same search that do not meet."""

from collections.abc import Iterable, Iterator

from plumbline.harness.findings.changes.values import Change, Sense
from plumbline.harness.findings.limits_found import Search, searches
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
            yield _change(earlier, after)


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


def _sense(before: Search, after: Search) -> Sense:
    if before.verdict not in _ANSWERED or after.verdict not in _ANSWERED:
        return "worse" if before.verdict in _ANSWERED and after.verdict == "stopped" else "neither"
    (held, broke), (holds, breaks) = _extent(before), _extent(after)
    if holds >= broke:
        return "better"
    return "worse" if breaks <= held else "within tolerance"


def _change(before: Search, after: Search) -> Change:
    both = before.held is not None and after.held is not None and before.held > 0 and after.held > 0
    return Change(
        kind="limit",
        sense=_sense(before, after),
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
