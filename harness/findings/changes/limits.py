"""Limits that moved: brackets of the same search that do not meet."""

from collections.abc import Iterable, Iterator

from harness.findings.changes.values import Change, Sense
from harness.findings.limits_found import Search, searches
from harness.store.store import Store

__all__ = ["limit_changes", "moved_limits"]

_ANSWERED = ("limit", "beyond the extreme", "not even the easiest")


def limit_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each search whose bracket or verdict is another; brackets that share a stretch may hold the same limit."""
    return moved_limits(searches(store_a), searches(store_b))


def moved_limits(searched: Iterable[Search], searched_again: Iterable[Search]) -> Iterator[Change]:
    """The same of searches; those for remedies are left out."""
    before = {_key(one): one for one in searched if not one.remedied}
    for after in [one for one in searched_again if not one.remedied]:
        one = before.get(_key(after))
        if one is not None and (one.held, one.broke, one.verdict) != (after.held, after.broke, after.verdict):
            yield _change(one, after)


def _key(one: Search) -> tuple[object, ...]:
    return one.experiment, one.case, one.where, one.engine, one.track, one.parts, one.axis


def _extent(one: Search) -> tuple[float, float]:
    """From what held to what broke, counted in the direction of harder; the ends of the axis where one is missing."""
    sign = 1.0 if one.extreme > one.easy else -1.0
    held = one.easy if one.held is None else one.held
    broke = one.extreme if one.broke is None else one.broke
    if one.verdict == "not even the easiest":
        held = broke = one.easy
    if one.verdict == "beyond the extreme":
        held = broke = one.extreme
    return sign * held, sign * broke


def _sense(one: Search, after: Search) -> Sense:
    if one.verdict not in _ANSWERED or after.verdict not in _ANSWERED:
        return "worse" if one.verdict in _ANSWERED and after.verdict == "stopped" else "neither"
    (held, broke), (holds, breaks) = _extent(one), _extent(after)
    if holds >= broke:
        return "better"
    return "worse" if breaks <= held else "within tolerance"


def _change(one: Search, after: Search) -> Change:
    both = one.held is not None and after.held is not None and one.held > 0 and after.held > 0
    return Change(
        kind="limit",
        sense=_sense(one, after),
        case=after.case,
        engine=after.engine,
        track=after.setting,
        where=after.where,
        dt=after.dt,
        metric=after.axis,
        unit=after.unit,
        trial_a=one.trial_broke or one.trial_held,
        trial_b=after.trial_broke or after.trial_held,
        before=one.verdict if one.held is None else one.held,
        after=after.verdict if after.held is None else after.held,
        ratio=after.held / one.held if both and one.held and after.held else None,
        detail=after.signs.brief or after.reason,
    )
