"""What breaks, for the first page: the limits that were met, an axis a line, and the failures by their causes."""

from collections.abc import Sequence
from dataclasses import dataclass

from plumbline.harness.findings.limits_found import CONSTANT, Search, searches_if_described
from plumbline.harness.findings.parameter_words import called
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import cases, engines
from plumbline.reports.words.text import amount


@dataclass(frozen=True, slots=True)
class Reached:
    """How far one engine goes. Terms: words: 'to 20', 'not even 1', 'beyond 100'; sign: by what it breaks there, '' where
    nothing tried breaks it. trial: the run that breaks, or the last that holds."""

    engine: str
    words: str
    sign: str
    share: float
    trial: str


@dataclass(frozen=True, slots=True)
class Limit:
    """One axis of a case: who breaks first stands first. Terms: axis: in words; unit: of its values; setting: all have it."""

    case: str
    title: str
    axis: str
    unit: str
    setting: str
    reached: Sequence[Reached]


def limits_met(store: Store) -> list[Limit]:
    """One line a case: of its axes the one on which the engines that people can deploy come the shortest way.

    Of several settings the tuned track at the coarsest equal sub-step speaks, or as it comes where none was asked for; of axes
    that nobody breaks nothing is said.
    """
    by_axis: dict[tuple[str, str, str], list[Search]] = {}
    for search in searches_if_described(store):
        if (
            not search.remedied
            and search.track == "tuned"
            and search.verdict
            not in (
                "unsupported",
                "unavailable",
                "stopped",
                CONSTANT,
            )
        ):
            by_axis.setdefault(search.searched_along, []).append(search)
    best: dict[str, Limit] = {}
    yard = {name for name, engine in engines(store).items() if engine["ours"]}
    for (_, case, where), group in by_axis.items():
        parts = min((search.parts for search in group if search.parts), default=0)
        level = [search for search in group if search.parts == parts]
        reached = sorted((_reached(search) for search in level), key=lambda reached: reached.share)
        if not any(entry.sign and entry.engine not in yard for entry in reached):
            continue
        first = level[0]
        limit = Limit(
            case=case,
            title=str(cases(store)[case]["title"]) + (f", {where}" if where else ""),
            axis=called(case, first.axis),
            unit="" if first.unit == "1" else first.unit,
            setting=first.setting,
            reached=reached,
        )
        if case not in best or _way(limit, yard) < _way(best[case], yard):
            best[case] = limit
    return sorted(best.values(), key=lambda limit: _way(limit, yard))


def _way(limit: Limit, yard: set[str]) -> float:
    """The shortest way of an engine that is not ours, as a share of the axis."""
    return min((reached.share for reached in limit.reached if reached.engine not in yard), default=1.0)


def _reached(search: Search) -> Reached:
    if search.broke is None:
        return Reached(search.engine, f"beyond {amount(search.held)}", "", 1.0, search.trial_held)
    words = f"not even {amount(search.easy)}" if search.held is None else f"to {amount(search.held)}"
    sign = metric_title(search.signs.counts[0][0]) if search.signs.counts else search.signs.status
    return Reached(search.engine, words, sign or "breaks", search.reach, search.trial_broke)
