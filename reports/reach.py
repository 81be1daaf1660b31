"""How far engines go, as people read it: a line for each axis, a map where it was sought at several values of another."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from harness.findings.emulations import whose
from harness.findings.leads import Lead, Reach, reaches
from harness.findings.limits_found import Search
from harness.findings.parameter_words import axis_title, called
from harness.findings.tables.remedies import Remedied
from harness.findings.where import STEP, in_words
from harness.metric.titles import metric_title
from reports.contents import cases
from reports.disputes import disputed
from reports.figure import Figure
from reports.grammar import channel, chart
from reports.marks import POINT, Marks, at_values, decades, finished, logarithmic
from reports.points import labels
from reports.text import amount, plural, slug

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["Cell", "Line", "Standing", "Tally", "lines", "maps", "marked", "standings", "tally", "worded"]

Row = dict[str, Any]
_ROOM = 64
"""Characters that a cell has room for of why an engine broke; hovering tells the rest."""
VERDICTS = {"beyond the extreme": "held to the end of the axis", "not even the easiest": "broke at the easy end"}
"""What a search says of an axis, in words that claim nothing of what was not tried."""


@dataclass(frozen=True, slots=True)
class Cell:
    """Where one engine ends: in words, why, and what hovering says."""

    reach: float
    text: str
    why: str
    hint: str


@dataclass(frozen=True, slots=True)
class Line:
    """One axis, with a cell for each engine under each condition: a sub-step, a CPU time, or a track as it comes."""

    case: str
    title: str
    axis: str
    conditions: Sequence[str]
    cells: Mapping[tuple[str, str], Cell]


@dataclass(frozen=True, slots=True)
class Tally:
    """How often a remedy helped, of how many places, and its cost in the middle of those."""

    helped: int
    tried: int
    cost: float | None


def lines(store: "Store", searches: Sequence[Search]) -> list[Line]:
    """A line for each axis; what was sought for a map stands there alone."""
    mapped = {(search.experiment, search.case) for _, group in _mapped(searches) for search in group}
    by_axis: dict[tuple[str, str, str], list[Search]] = {}
    for search in searches:
        if (search.experiment, search.case) not in mapped:
            by_axis.setdefault((search.experiment, search.case, search.where), []).append(search)
    made = []
    for (_, case, where), group in by_axis.items():
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
        cells |= {(reach.engine, worded(reach)): _within(reach) for reach in reaches(group) if reach.at == "equal time"}
        cells = {key: marked(unmarked, against[key[0]]) for key, unmarked in cells.items()}
        made.append(Line(case, title, axis, list(dict.fromkeys(setting for _, setting in cells)), cells))
    return made


def _order(search: Search) -> tuple[bool, int, str]:
    """Equal sub-steps first, the coarsest of them at the top; then tracks as they come."""
    return not search.parts, search.parts, search.track


def worded(reach: Reach) -> str:
    """A condition in words."""
    if reach.parts:
        return f"time step / {reach.parts}" if reach.parts > 1 else "time step undivided"
    return f"≤ {amount(1e3 * reach.condition)} ms a step"


def _within(reach: Reach) -> Cell:
    """What an engine held for so much time, and how."""
    if reach.held is None or reach.cost is None:
        return Cell(0.0, "none", "", "nothing was held at this price")
    hint = f"{reach.setting}; {amount(1e3 * reach.cost)} ms of CPU time for a time step of the case, roughly"
    return Cell(reach.reach, amount(reach.held), reach.setting, hint)


def _first_clause(reason: str) -> str:
    """What a narrow cell has room for of a reason."""
    return reason.partition(":")[0]


def cell(search: Search, law: str = "") -> Cell:
    """One search in words; law: whose laws it is about, where they are not all the engine's own."""
    if search.verdict == "beyond the extreme":
        text, why = f"≥ {amount(search.held)}", ""
    elif search.held is None:
        text = VERDICTS.get(search.verdict, search.verdict) if search.broke is None else f"< {amount(search.easy)}"
        why = _signs(search) or _first_clause(search.reason)
    else:
        text, why = amount(search.held), _signs(search) if search.broke is not None else search.verdict
    share = "" if search.share is None else f"; {100 * search.share:.0f} % held at {amount(search.broke)}"
    cost = "" if search.step_cost is None else f"; {amount(1e3 * search.step_cost)} ms of CPU time a time step at the limit"
    taken = "" if search.substep is None else f"; steps of {amount(1e3 * search.substep)} ms taken"
    verdict = VERDICTS.get(search.verdict, search.verdict)
    whole_reason = search.reason or _signs(search, why=True)
    hint = f"{verdict}{share}{cost}{taken}; {search.values} values, {search.members} starts each; {whole_reason}"
    # What breaks at other starts than the case's own, or with effects that no scene called for, is said to.
    own = "the case's own start holds" if search.own_holds and search.broke is not None else ""
    hint = "; ".join(word for word in (hint, own, *map(str, search.noticed)) if word)
    words = "; ".join(word for word in (shorten(why, _ROOM, placeholder=" …"), own, law) if word)
    return Cell(search.reach, text, words, f"{hint}; {law}" if law else hint)


def marked(unmarked: Cell, against: str) -> Cell:
    """A cell with what is said against it, where it is disputed."""
    if not against:
        return unmarked
    words, hint = (", ".join(word for word in (unmarked.why, "disputed") if word), f"{unmarked.hint}; {against}")
    return replace(unmarked, why=words, hint=hint)


@dataclass(frozen=True, slots=True)
class Standing:
    """Under one condition, by engine: how often it leads alone and with others, with ours and without.

    Terms: of: how many were asked among the engines of others; of_with_ours: among all.
    """

    what: str
    condition: str
    of: int
    of_with_ours: int
    engines: Mapping[str, tuple[Lead, Lead | None]]


def standings(leads: Sequence[Lead]) -> list[Standing]:
    """A row for each condition."""
    by_condition: dict[tuple[str, str, str], dict[str, dict[bool, Lead]]] = {}
    for lead in leads:
        by_condition.setdefault((lead.what, lead.at, lead.condition), {}).setdefault(lead.engine, {})[lead.ours] = lead
    rows: list[Standing] = []
    for (what, at, condition), by in by_condition.items():
        of_with_ours = max(rankings[True].of for rankings in by.values())
        of = max((rankings[False].of for rankings in by.values() if False in rankings), default=of_with_ours)
        engines = {engine: (rankings[True], rankings.get(False)) for engine, rankings in by.items()}
        rows.append(Standing(what, f"{at}{f': {condition}' if condition else ''}", of, of_with_ours, engines))
    return rows


def _mapped(searches: Sequence[Search]) -> list[tuple[str, list[Search]]]:
    """The searches of each experiment and case that ran at three or more values of one thing beside its axis, with its name."""
    groups: dict[tuple[str, str], list[Search]] = {}
    for search in searches:
        groups.setdefault((search.experiment, search.case), []).append(search)
    named = [
        (next((name for name, values in _numbers(group).items() if len(values) >= 3), ""), group) for group in groups.values()
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


def maps(store: "Store", searches: Sequence[Search]) -> list[Figure]:
    """A chart for each case that was sought at several values of something else."""
    return [figure for name, group in _mapped(searches) for figure in _map(store, name, group)]


def _map(store: "Store", name: str, group: Sequence[Search]) -> list[Figure]:
    first = group[0]
    rest = sorted({(_rest(search, name), search.parts) for search in group})
    figures = []
    for flags, parts in rest:
        rows: list[Row] = []
        other = ", ".join(word for word in (flags, f"time step / {parts}" if parts > 1 else "") if word)
        for search in group:
            value: Any = dict(search.beside).get(name)
            if (
                (_rest(search, name), search.parts) != (flags, parts)
                or value is None
                or search.verdict in ("unsupported", "unavailable")
            ):
                continue
            rows.append(
                {
                    "engine": labels(store)[search.engine],
                    "track": search.track,
                    "series": f"{search.engine} {search.setting}",
                    "beside": 1e3 * value if name == STEP else value,
                    "held": search.held if search.held is not None else search.easy,
                    "broke": search.broke if search.broke is not None else search.extreme,
                    "mark": "held"
                    if search.verdict == "beyond the extreme"
                    else "none holds"
                    if search.held is None
                    else "limit",
                    "signs": _signs(search, why=True),
                    "verdict": VERDICTS.get(search.verdict, search.verdict),
                }
            )
        if not rows:
            continue
        style = Marks(store, rows)
        title_x = "time step [ms]" if name == STEP else axis_title(first.case, name)
        title_y = axis_title(first.case, first.axis, first.unit)
        x = logarithmic("beside", title_x, at_values([row["beside"] for row in rows]))
        spread = [row[key] for row in rows for key in ("held", "broke")]
        y = logarithmic("held", title_y, decades(spread))
        shown = [
            channel("engine:N"),
            channel("track:N"),
            channel("beside:Q", title=title_x, format=".3~g"),
            channel("held:Q", title="all starts held", format=".3~g"),
            channel("broke:Q", title="not all held", format=".3~g"),
            channel("signs:N", title="broke by"),
            channel("verdict:N"),
        ]
        channels = style.channels() | {"tooltip": shown}
        layers = [
            chart(rows)
            .marked("line", strokeWidth=1.6)
            .encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash()),
            chart([row for row in rows if row["mark"] == "limit"])
            .marked("rule", strokeWidth=3, opacity=0.35)
            .encode(x=x, y=y, y2="broke:Q", color=style.colour()),
            chart(rows).marked("point", **POINT | {"size": 60}).encode(x=x, y=y, **channels),
        ]
        title = cases(store)[first.case]["title"] + (f", {other}" if other else "")
        figures.append(
            Figure(
                f"map-{slug(first.experiment)}-{slug(first.case)}{'-' + slug(other) if other else ''}",
                title,
                f"The hardest {title_y} that every start held.",
                finished(layers, height=190),
                ("engine", "setting", title_x, "held", "broke", "by", "verdict"),
                [
                    [
                        r["engine"],
                        r["track"],
                        amount(r["beside"]),
                        amount(r["held"]),
                        amount(r["broke"]),
                        r["signs"],
                        r["verdict"],
                    ]
                    for r in rows
                ],
                f"Bars span to the first that not all held. At {amount(first.easy)} nothing harder than the start of the axis "
                f"held, at {amount(first.extreme)} its end.",
            )
        )
    return figures


def _rest(search: Search, name: str) -> str:
    """What stands beside the axis and that number, in words: 'continuous on'."""
    return in_words([(other, value) for other, value in search.beside if other != name])


def _signs(search: Search, *, why: bool = False) -> str:
    """By what a value broke, with how many starts each metric counts against. Args: why: with the reason of no ensemble?"""
    counted = ", ".join(f"{metric_title(metric)} ({plural(count, 'start')})" for metric, count in search.signs.counts)
    return counted or (search.signs.text if why else search.signs.status)


def tally(remedies: Sequence[Remedied]) -> list[tuple[str, Mapping[str, Tally]]]:
    """By remedy and engine, how often it helped where it was tried; the most helpful first."""
    by_remedy: dict[str, dict[str, list[Remedied]]] = {}
    for remedied in remedies:
        if remedied.share_after is not None:
            by_remedy.setdefault(remedied.remedy, {}).setdefault(remedied.engine, []).append(remedied)
    counted = {remedy: {engine: _counted(tried) for engine, tried in by.items()} for remedy, by in by_remedy.items()}
    return sorted(counted.items(), key=lambda item: -sum(count.helped for count in item[1].values()))


def _counted(tried: Sequence[Remedied]) -> Tally:
    helped = [remedied for remedied in tried if remedied.verdict == "helps"]
    costs = [remedied.cost_ratio for remedied in helped if remedied.cost_ratio is not None]
    return Tally(len(helped), len(tried), median(costs) if costs else None)
