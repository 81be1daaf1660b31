"""How far engines go, as people read it: a line for each axis, a map where it was sought at several values of another."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import TYPE_CHECKING, Any

from harness.findings.emulations import whose
from harness.findings.leads import Lead, Reach, reaches
from harness.findings.limits_found import Search
from harness.findings.tables.remedies import Remedied
from harness.findings.where import STEP, in_words
from reports.contents import cases
from reports.disputes import disputed
from reports.figure import Figure
from reports.marks import POINT, Marks, chart, decades, finished, logarithmic
from reports.points import labels
from reports.text import amount, slug

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["Cell", "Line", "Standing", "Tally", "lines", "maps", "marked", "standings", "tally", "worded"]

Row = dict[str, Any]
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
    mapped = {(one.experiment, one.case) for group in _mapped(searches) for one in group}
    found: dict[tuple[str, str, str], list[Search]] = {}
    for one in searches:
        if (one.experiment, one.case) not in mapped:
            found.setdefault((one.experiment, one.case, one.where), []).append(one)
    made = []
    for (_, case, where), group in found.items():
        first = group[0]
        unit = "" if first.unit == "1" else f" {first.unit}"
        title = cases(store)[case]["title"] + (f", {where}" if where else "")
        axis = f"{first.axis.replace('_', ' ')} {amount(first.easy)} … {amount(first.extreme)}{unit}"
        laws = {(one.engine, one.track): whose(store.catalogue, one.engine, case, one.track) for one in group}
        against = {one.engine: disputed(store, one.engine, case, one.axis) for one in group}
        cells = {(one.engine, one.setting): cell(one, laws[one.engine, one.track]) for one in sorted(group, key=_order)}
        cells |= {(one.engine, worded(one)): _within(one) for one in reaches(group) if one.at == "equal time"}
        cells = {key: marked(one, against[key[0]]) for key, one in cells.items()}
        made.append(Line(case, title, axis, list(dict.fromkeys(setting for _, setting in cells)), cells))
    return made


def _order(one: Search) -> tuple[bool, int, str]:
    """Equal sub-steps first, the coarsest of them at the top; then tracks as they come."""
    return not one.parts, one.parts, one.track


def worded(one: Reach) -> str:
    """A condition in words."""
    if one.parts:
        return "sub-step dt" + (f"/{one.parts}" if one.parts > 1 else "")
    return f"≤ {amount(1e3 * one.condition)} ms a step"


def _within(one: Reach) -> Cell:
    """What an engine held for so much time, and how."""
    if one.held is None or one.cost is None:
        return Cell(0.0, "none", "", "nothing was held at this price")
    hint = f"{one.setting}; {amount(1e3 * one.cost)} ms of CPU time for a time step of the case, roughly"
    return Cell(one.reach, amount(one.held), one.setting, hint)


def _first_clause(reason: str) -> str:
    """What a narrow cell has room for of a reason."""
    return reason.partition(":")[0]


def cell(one: Search, law: str = "") -> Cell:
    """One search in words; law: whose laws it is about, where they are not all the engine's own."""
    if one.verdict == "beyond the extreme":
        text, why = f"≥ {amount(one.held)}", ""
    elif one.held is None:
        text = VERDICTS.get(one.verdict, one.verdict) if one.broke is None else f"< {amount(one.easy)}"
        why = one.signs.brief or _first_clause(one.reason)
    else:
        text, why = amount(one.held), one.signs.brief if one.broke is not None else one.verdict
    share = "" if one.share is None else f"; {100 * one.share:.0f} % held at {amount(one.broke)}"
    cost = "" if one.step_cost is None else f"; {amount(1e3 * one.step_cost)} ms of CPU time a time step at the limit"
    taken = "" if one.substep is None else f"; steps of {amount(1e3 * one.substep)} ms taken"
    verdict = VERDICTS.get(one.verdict, one.verdict)
    hint = f"{verdict}{share}{cost}{taken}; {one.values} values, {one.members} starts each; {one.reason or one.signs.text}"
    # What breaks at other starts than the case's own, or with effects that no scene called for, is said to.
    own = "the case's own start holds" if one.own_holds and one.broke is not None else ""
    hint = "; ".join(word for word in (hint, own, *map(str, one.noticed)) if word)
    words = "; ".join(word for word in (why[:40], own, law) if word)
    return Cell(one.reach, text, words, f"{hint}; {law}" if law else hint)


def marked(one: Cell, against: str) -> Cell:
    """A cell with what is said against it, where it is disputed."""
    if not against:
        return one
    words, hint = (", ".join(word for word in (one.why, "disputed") if word), f"{one.hint}; {against}")
    return replace(one, why=words, hint=hint)


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
    found: dict[tuple[str, str, str], dict[str, dict[bool, Lead]]] = {}
    for one in leads:
        found.setdefault((one.what, one.at, one.condition), {}).setdefault(one.engine, {})[one.ours] = one
    rows: list[Standing] = []
    for (what, at, condition), by in found.items():
        of_with_ours = max(one[True].of for one in by.values())
        of = max((one[False].of for one in by.values() if False in one), default=of_with_ours)
        engines = {engine: (one[True], one.get(False)) for engine, one in by.items()}
        rows.append(Standing(what, f"{at}{f': {condition}' if condition else ''}", of, of_with_ours, engines))
    return rows


def _mapped(searches: Sequence[Search]) -> list[list[Search]]:
    """The searches of each experiment and case that ran at three or more values of one thing beside its axis."""
    groups: dict[tuple[str, str], list[Search]] = {}
    for one in searches:
        groups.setdefault((one.experiment, one.case), []).append(one)
    return [group for group in groups.values() if len({_beside(one)[1] for one in group if _beside(one)[0]}) >= 3]


def _beside(one: Search) -> tuple[str, float | None]:
    """Name and value of the number that stands beside the axis, the time step in seconds; '' where it is none."""
    numbers = ((name, value) for name, value in one.beside if isinstance(value, int | float) and not isinstance(value, bool))
    return next(numbers, ("", None))


def maps(store: "Store", searches: Sequence[Search]) -> list[Figure]:
    """A chart for each case that was sought at several values of something else."""
    return [figure for group in _mapped(searches) for figure in _map(store, group)]


def _map(store: "Store", group: Sequence[Search]) -> list[Figure]:
    import altair as alt  # late: half a second that only a report needs

    first = group[0]
    rest = sorted({(_rest(one), one.parts) for one in group})
    figures = []
    for told, parts in rest:
        rows: list[Row] = []
        other = ", ".join(word for word in (told, f"sub-step dt/{parts}" if parts > 1 else "") if word)
        for one in group:
            name, value = _beside(one)
            if (_rest(one), one.parts) != (told, parts) or value is None or one.verdict in ("unsupported", "unavailable"):
                continue
            rows.append(
                {
                    "engine": labels(store)[one.engine],
                    "track": one.track,
                    "series": f"{one.engine} {one.setting}",
                    "beside": 1e3 * value if name == STEP else value,
                    "held": one.held if one.held is not None else one.easy,
                    "broke": one.broke if one.broke is not None else one.extreme,
                    "mark": "held" if one.verdict == "beyond the extreme" else "none holds" if one.held is None else "limit",
                    "signs": one.signs.text,
                    "verdict": VERDICTS.get(one.verdict, one.verdict),
                }
            )
        if not rows:
            continue
        style = Marks(store, rows)
        name = _beside(first)[0]
        title_x = "time step [ms]" if name == STEP else name.replace("_", " ")
        unit = "" if first.unit == "1" else f" [{first.unit}]"
        title_y = f"{first.axis.replace('_', ' ')}{unit}"
        x = logarithmic(alt.X, "beside", title_x, decades(row["beside"] for row in rows))
        spread = [row[key] for row in rows for key in ("held", "broke")]
        y = logarithmic(alt.Y, "held", title_y, decades(spread))
        shown = [
            alt.Tooltip("engine:N"),
            alt.Tooltip("track:N"),
            alt.Tooltip("beside:Q", title=title_x, format=".4~g"),
            alt.Tooltip("held:Q", title="all starts held", format=".4~g"),
            alt.Tooltip("broke:Q", title="not all held", format=".4~g"),
            alt.Tooltip("signs:N", title="broke by"),
            alt.Tooltip("verdict:N"),
        ]
        channels = style.channels() | {"tooltip": shown}
        layers = [
            chart(rows)
            .mark_line(strokeWidth=1.6)
            .encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash()),
            chart([row for row in rows if row["mark"] == "limit"])
            .mark_rule(strokeWidth=3, opacity=0.35)
            .encode(x=x, y=y, y2="broke:Q", color=style.colour()),
            chart(rows).mark_point(**POINT | {"size": 60}).encode(x=x, y=y, **channels),
        ]
        told_title = cases(store)[first.case]["title"] + (f", {other}" if other else "")
        figures.append(
            Figure(
                f"map-{slug(first.experiment)}-{slug(first.case)}{'-' + slug(other) if other else ''}",
                told_title,
                f"The hardest {title_y} that every start held, over {title_x}; bars span to the first that not all held. "
                f"At {amount(first.easy)} nothing harder than the start of the axis held, at {amount(first.extreme)} its end.",
                finished(layers, height=300),
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
            )
        )
    return figures


def _rest(one: Search) -> str:
    """What stands beside the axis and is no number, in words: 'continuous True'."""
    return in_words([(name, value) for name, value in one.beside if isinstance(value, bool)])


def tally(remedies: Sequence[Remedied]) -> list[tuple[str, Mapping[str, Tally]]]:
    """By remedy and engine, how often it helped where it was tried; the most helpful first."""
    found: dict[str, dict[str, list[Remedied]]] = {}
    for one in remedies:
        if one.share_after is not None:
            found.setdefault(one.remedy, {}).setdefault(one.engine, []).append(one)
    told = {remedy: {engine: _counted(tried) for engine, tried in by.items()} for remedy, by in found.items()}
    return sorted(told.items(), key=lambda item: -sum(one.helped for one in item[1].values()))


def _counted(tried: Sequence[Remedied]) -> Tally:
    helped = [one for one in tried if one.verdict == "helps"]
    costs = [one.cost_ratio for one in helped if one.cost_ratio is not None]
    return Tally(len(helped), len(tried), median(costs) if costs else None)
