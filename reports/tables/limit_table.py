"""How far engines go, as people read it: a line for each axis, of each case the axis that breaks first, and who leads under
each condition.

Remedies: how often each helped, counted and in words, and what that costs.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from statistics import median
from textwrap import shorten

from plumbline.harness.findings.emulations import whose
from plumbline.harness.findings.limits_found import CONSTANT, Search, searches_if_described
from plumbline.harness.findings.parameter_words import called
from plumbline.harness.findings.standing import Lead, Reach, reaches
from plumbline.harness.findings.tables.remedies import Remedied
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import cases, engines
from plumbline.reports.words.known_findings import disputed
from plumbline.reports.words.text import amount, join_words, plural

_ROOM = 64
"""Characters that a cell has room for of why an engine broke; hovering tells the rest."""
VERDICTS = {"beyond the extreme": "held to the end of the axis", "not even the easiest": "broke at the easy end"}
"""What a search says of an axis, in words that claim nothing of what was not tried."""


@dataclass(frozen=True, slots=True)
class LimitCell:
    """Where one engine ends: in words, why, and what hovering says. curve: its error along the axis, as points of a line."""

    reach: float
    text: str
    why: str
    hint: str
    curve: str = ""


@dataclass(frozen=True, slots=True)
class AxisLine:
    """One axis, with a cell for each engine under each condition: a sub-step, a CPU time, or a track as it comes."""

    case: str
    title: str
    axis: str
    conditions: Sequence[str]
    cells: Mapping[tuple[str, str], LimitCell]


def lines(store: Store, searches: Sequence[Search]) -> list[AxisLine]:
    """A line for each axis; what was sought for a map stands there alone."""
    on_maps = {(search.experiment, search.case) for _, group in mapped(searches) for search in group}
    made = []
    beside_maps = (search for search in searches if (search.experiment, search.case) not in on_maps)
    for (_, case, where), group in grouped(beside_maps, attrgetter("searched_along")).items():
        first = group[0]
        unit = "" if first.unit == "1" else f" {first.unit}"
        title = cases(store)[case]["title"] + (f", {where}" if where else "")
        axis = f"{called(case, first.axis)} {amount(first.easy)} … {amount(first.extreme)}{unit}"
        laws = {(search.engine, search.track): whose(store.catalogue, search.engine, case, search.track) for search in group}
        against = {search.engine: disputed(store, search.engine, case, search.axis) for search in group}
        cells = {
            (search.engine, search.setting): cell(search, laws[search.engine, search.track])
            for search in sorted(group, key=_order)
        }
        cells |= {(reach.search.engine, worded(reach)): _within(reach) for reach in reaches(group) if reach.at == "equal time"}
        cells = {key: marked(unmarked, against[key[0]]) for key, unmarked in cells.items()}
        made.append(AxisLine(case, title, axis, list(dict.fromkeys(setting for _, setting in cells)), cells))
    return made


def _order(search: Search) -> tuple[bool, int, str]:
    """Equal sub-steps first, the coarsest of them at the top; then tracks as they come."""
    return not search.parts, search.parts, search.track


def worded(reach: Reach) -> str:
    """A condition in words."""
    if reach.parts:
        return f"time step / {reach.parts}" if reach.parts > 1 else "time step undivided"
    return f"≤ {amount(1e3 * reach.condition)} ms a step"


def _within(reach: Reach) -> LimitCell:
    """What an engine held for so much time, and how."""
    hold, setting = reach.hold, reach.search.setting
    if hold is None or hold.cost is None:
        return LimitCell(0.0, "none", "", "nothing was held at this price")
    hint = f"{setting}; {amount(1e3 * hold.cost)} ms of CPU time for a time step of the case, roughly"
    return LimitCell(hold.reach, amount(hold.value), setting, hint)


def cell(search: Search, law: str = "") -> LimitCell:
    """One search in words; law: whose laws it is about, where they are not all the engine's own."""
    if search.verdict == CONSTANT:
        text, why = CONSTANT, f"{metric_title(search.signs.counts[0][0])} alike at both ends: {search.along_in_words}"
    elif search.verdict == "beyond the extreme":
        text, why = f"≥ {amount(search.held)}", ""
    elif search.held is None:
        text = VERDICTS.get(search.verdict, search.verdict) if search.broke is None else f"< {amount(search.easy)}"
        why = signs(search) or search.reason.partition(":")[0]
    else:
        text, why = amount(search.held), signs(search) if search.broke is not None else search.verdict
    share = "" if search.share is None else f"; {100 * search.share:.0f} % held at {amount(search.broke)}"
    cost = "" if search.step_cost is None else f"; {amount(1e3 * search.step_cost)} ms of CPU time a time step at the limit"
    taken = "" if search.substep is None else f"; steps of {amount(1e3 * search.substep)} ms taken"
    verdict = VERDICTS.get(search.verdict, search.verdict)
    whole_reason = search.reason or signs(search, why=True)
    hint = f"{verdict}{share}{cost}{taken}; {search.values} values, {search.members} starts each; {whole_reason}"
    hint += f"; error {search.along_in_words}" if search.along else ""
    # What breaks at other starts than the case's own, or with effects that no scene called for, is said to.
    own = "the case's own start holds" if search.own_holds and search.broke is not None else ""
    hint = "; ".join(word for word in (hint, own, *map(str, search.noticed)) if word)
    words = "; ".join(word for word in (shorten(why, _ROOM, placeholder=" …"), own, law) if word)
    reach = 0.0 if search.verdict == CONSTANT else search.reach
    return LimitCell(reach, text, words, f"{hint}; {law}" if law else hint, _curve(search))


def _curve(search: Search) -> str:
    """The headline error over its bar, against the axis: 100 wide, and 20 high from a thousandth to ten times; the bar is at 5.
    '' of fewer than two values."""
    easy, extreme = search.easy, search.extreme
    points = []
    for point in search.along:
        logarithmic = min(easy, extreme) > 0
        share = math.log(point.value / easy, extreme / easy) if logarithmic else (point.value - easy) / (extreme - easy)
        over = min(max(point.error / point.bar, 1e-3), 10.0) if point.bar > 0 and point.error == point.error else 10.0
        points.append(f"{100 * share:.1f},{5 - 5 * math.log10(over):.1f}")
    return " ".join(points) if len(points) > 1 else ""


def marked(unmarked: LimitCell, against: str) -> LimitCell:
    """A cell with what is said against it, where it is disputed."""
    if not against:
        return unmarked
    words, hint = (", ".join(word for word in (unmarked.why, "disputed") if word), f"{unmarked.hint}; {against}")
    return replace(unmarked, why=words, hint=hint)


@dataclass(frozen=True, slots=True)
class LeadCounts:
    """Under one condition, by engine: how often it leads alone and with others, with ours and without.

    Terms: of: how many were asked among the engines of others; of_with_ours: among all.
    """

    what: str
    condition: str
    of: int
    of_with_ours: int
    engines: Mapping[str, tuple[Lead, Lead | None]]


def standings(leads: Sequence[Lead]) -> list[LeadCounts]:
    """A row for each condition."""
    by_condition: dict[tuple[str, str, str], dict[str, dict[bool, Lead]]] = {}
    for lead in leads:
        by_condition.setdefault((lead.what, lead.at, lead.condition), {}).setdefault(lead.engine, {})[lead.ours] = lead
    rows: list[LeadCounts] = []
    for (what, at, condition), by in by_condition.items():
        of_with_ours = max(rankings[True].of for rankings in by.values())
        of = max((rankings[False].of for rankings in by.values() if False in rankings), default=of_with_ours)
        engines = {engine: (rankings[True], rankings.get(False)) for engine, rankings in by.items()}
        rows.append(LeadCounts(what, f"{at}{f': {condition}' if condition else ''}", of, of_with_ours, engines))
    return rows


def signs(search: Search, *, why: bool = False) -> str:
    """By what a value broke, with how many starts each metric counts against. Args: why: with the reason of no ensemble?"""
    counted = ", ".join(f"{metric_title(metric)} ({plural(count, 'start')})" for metric, count in search.signs.counts)
    return counted or (search.signs.text if why else search.signs.status)


def mapped(searches: Sequence[Search]) -> list[tuple[str, list[Search]]]:
    """The searches of each experiment and case that ran at three or more values of one thing beside its axis, with its name."""
    named = [
        (next((name for name, values in _numbers(group).items() if len(values) >= 3), ""), group)
        for group in grouped(searches, attrgetter("experiment", "case")).values()
    ]
    return [(name, group) for name, group in named if name]


def _numbers(searches: Sequence[Search]) -> dict[str, set[float]]:
    """The values of each number that stands beside the axis, the time step in seconds."""
    values: dict[str, set[float]] = {}
    for search in searches:
        for name, value in search.beside:
            if isinstance(value, int | float) and not isinstance(value, bool):
                values.setdefault(name, set()).add(value)
    return values


@dataclass(frozen=True, slots=True)
class ReachedLimit:
    """How far one engine goes. Terms: words: 'to 20', 'not even 1', 'beyond 100'; sign: by what it breaks there, '' where
    nothing tried breaks it. trial: the run that breaks, or the last that holds."""

    engine: str
    words: str
    sign: str
    share: float
    trial: str


@dataclass(frozen=True, slots=True)
class LimitMet:
    """One axis of a case: who breaks first stands first. Terms: axis: in words; unit: of its values; setting: all have it."""

    case: str
    title: str
    axis: str
    unit: str
    setting: str
    reached: Sequence[ReachedLimit]


def limits_met(store: Store) -> list[LimitMet]:
    """One line a case: of its axes the one on which the engines that people can deploy come the shortest way.

    Of several settings the tuned track at the coarsest equal sub-step speaks, or as it comes where none was asked for; of axes
    that nobody breaks nothing is said.
    """
    silent = ("unsupported", "unavailable", "stopped", CONSTANT)
    tuned = (s for s in searches_if_described(store) if not s.remedied and s.track == "tuned" and s.verdict not in silent)
    best: dict[str, LimitMet] = {}
    yard = {name for name, engine in engines(store).items() if engine["ours"]}
    for (_, case, where), group in grouped(tuned, attrgetter("searched_along")).items():
        parts = min((search.parts for search in group if search.parts), default=0)
        level = [search for search in group if search.parts == parts]
        reached = sorted((_reached(search) for search in level), key=lambda reached: reached.share)
        if not any(entry.sign and entry.engine not in yard for entry in reached):
            continue
        first = level[0]
        limit = LimitMet(
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


def _way(limit: LimitMet, yard: set[str]) -> float:
    """The shortest way of an engine that is not ours, as a share of the axis."""
    return min((reached.share for reached in limit.reached if reached.engine not in yard), default=1.0)


def _reached(search: Search) -> ReachedLimit:
    if search.broke is None:
        return ReachedLimit(search.engine, f"beyond {amount(search.held)}", "", 1.0, search.trial_held)
    words = f"not even {amount(search.easy)}" if search.held is None else f"to {amount(search.held)}"
    sign = metric_title(search.signs.counts[0][0]) if search.signs.counts else search.signs.status
    return ReachedLimit(search.engine, words, sign or "breaks", search.reach, search.trial_broke)


_WORDS = WORDS["remedies"]
_PLURAL = ("sub-steps x 4", "more iterations")


@dataclass(frozen=True, slots=True)
class Tally:
    """How often a remedy helped, of how many places, and its cost in the middle of those."""

    helped: int
    tried: int
    cost: float | None


def in_words(remedy: str) -> str:
    """What a remedy changes: 'four times the sub-steps', 'the solver sequential impulses'."""
    kind, _, value = remedy.partition(" ")
    return _WORDS.get(remedy) or (
        f"the {kind} {value.replace('_', ' ')}" if kind in ("solver", "integrator") else f"a {remedy}"
    )


def helped(tally: Sequence[tuple[str, Mapping[str, Tally]]]) -> list[str]:
    """A sentence for each remedy that helps somewhere, the most helpful first, and one for all that help nowhere."""
    sentences: list[tuple[float, str]] = []
    nowhere: list[str] = []
    for remedy, by_engine in tally:
        tallies = list(by_engine.values())
        times, tried = sum(one.helped for one in tallies), sum(one.tried for one in tallies)
        costs = sorted(one.cost for one in tallies if one.cost is not None)
        words = in_words(remedy)
        if not times:
            nowhere.append(words)
            continue
        price = f", at {_range(costs)} times the cost" if costs else ""
        verb = "help" if remedy in _PLURAL else "helps"
        sentence = f"{words[0].upper()}{words[1:]} {verb} in {times} of {plural(tried, 'place')}{price}."
        sentences.append((times / tried, sentence))
    listed = [sentence for _, sentence in sorted(sentences, key=lambda pair: -pair[0])]
    return [*listed, *([f"Tried without help anywhere: {join_words(nowhere)}."] if nowhere else [])]


def _range(costs: Sequence[float]) -> str:
    """The least and the most of engines, or one of both."""
    low, high = amount(costs[0], 2), amount(costs[-1], 2)
    return low if low == high else f"{low} to {high}"


def tally(remedies: Sequence[Remedied]) -> list[tuple[str, Mapping[str, Tally]]]:
    """By remedy and engine, how often it helped where it was tried; the most helpful first."""
    answered = [remedied for remedied in remedies if remedied.share_after is not None]
    counted = {
        remedy: {engine: _counted(mine) for engine, mine in grouped(tried, attrgetter("engine")).items()}
        for remedy, tried in grouped(answered, attrgetter("remedy")).items()
    }
    return sorted(counted.items(), key=lambda item: -sum(count.helped for count in item[1].values()))


def _counted(tried: Sequence[Remedied]) -> Tally:
    helped = [remedied for remedied in tried if remedied.verdict == "helps"]
    costs = [remedied.cost_ratio for remedied in helped if remedied.cost_ratio is not None]
    return Tally(len(helped), len(tried), median(costs) if costs else None)
