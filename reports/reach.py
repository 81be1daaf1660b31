"""How far engines go, as people read it: a line for each axis, a map where it was sought at several values of another."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

from harness.searches import Search
from harness.tables.remedies import Remedied
from reports.contents import cases
from reports.figure import Figure
from reports.marks import POINT, Marks, chart, decades, finished, logarithmic
from reports.points import labels
from reports.text import amount, slug

if TYPE_CHECKING:
    from harness.store import Store

__all__ = ["Cell", "Line", "Tally", "lines", "maps", "tally", "wins"]

Row = dict[str, Any]
TRACKS = ("tuned", "default")
AS_FAR = 1e-9
"""Shares of an axis that count as equal."""


@dataclass(frozen=True, slots=True)
class Cell:
    """Where one engine ends: in words, why, and what hovering says."""

    reach: float
    text: str
    why: str
    hint: str


@dataclass(frozen=True, slots=True)
class Line:
    """One axis, with a cell for each engine and track."""

    case: str
    title: str
    axis: str
    tracks: Sequence[str]
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
        tracks = [track for track in TRACKS if any(one.track == track for one in group)]
        made.append(Line(case, title, axis, tracks, {(one.engine, one.track): cell(one) for one in group}))
    return made


def cell(one: Search) -> Cell:
    """One search in words."""
    if one.verdict == "beyond the extreme":
        text, why = f"≥ {amount(one.held)}", ""
    elif one.held is None:
        text, why = one.verdict if one.broke is None else f"< {amount(one.easy)}", one.signs or one.reason
    else:
        text, why = amount(one.held), one.signs if one.broke is not None else one.verdict
    share = "" if one.share is None else f"; {100 * one.share:.0f} % held at {amount(one.broke)}"
    cost = "" if one.cost is None else f"; {amount(one.cost)} CPU s per simulated s at the limit"
    hint = f"{one.verdict}{share}{cost}; {one.values} values, {one.members} starts each; {one.reason or one.signs}"
    return Cell(one.reach, text, why.partition(":")[0][:40], hint)


def wins(shown: Sequence[Line]) -> list[tuple[str, int]]:
    """On how many axes an engine goes as far as the best, in its better setting; the most first."""
    count: Counter[str] = Counter()
    for line in shown:
        best = max((one.reach for one in line.cells.values()), default=0.0)
        for engine in dict.fromkeys(name for name, _ in line.cells):
            count[engine] += any(one.reach >= best - AS_FAR for (name, _), one in line.cells.items() if name == engine)
    return count.most_common()


def _mapped(searches: Sequence[Search]) -> list[list[Search]]:
    """The searches of each experiment and case that ran at three or more values of one thing beside its axis."""
    groups: dict[tuple[str, str], list[Search]] = {}
    for one in searches:
        groups.setdefault((one.experiment, one.case), []).append(one)
    return [group for group in groups.values() if len({_beside(one)[1] for one in group if _beside(one)[0]}) >= 3]


def _beside(one: Search) -> tuple[str, float | None]:
    """Name and value of the number that stands beside the axis; '' where it is none. 'thickness 0.01', 'dt 1/240 s'."""
    for word in one.where.split(", "):
        name, _, value = word.partition(" ")
        if name == "dt":
            return "dt", one.dt
        try:
            if value not in ("True", "False"):
                return name, float(value)
        except ValueError:
            continue
    return "", None


def maps(store: "Store", searches: Sequence[Search]) -> list[Figure]:
    """A chart for each case that was sought at several values of something else."""
    return [figure for group in _mapped(searches) for figure in _map(store, group)]


def _map(store: "Store", group: Sequence[Search]) -> list[Figure]:
    import altair as alt  # late: half a second that only a report needs

    first = group[0]
    rest = sorted({_rest(one) for one in group})
    figures = []
    for other in rest:
        rows: list[Row] = []
        for one in group:
            name, value = _beside(one)
            if _rest(one) != other or value is None or one.verdict in ("unsupported", "unavailable"):
                continue
            rows.append(
                {
                    "engine": labels(store)[one.engine],
                    "track": one.track,
                    "series": f"{one.engine} {one.track}",
                    "beside": 1e3 * value if name == "dt" else value,
                    "held": one.held if one.held is not None else one.easy,
                    "broke": one.broke if one.broke is not None else one.extreme,
                    "mark": "beyond" if one.verdict == "beyond the extreme" else "none holds" if one.held is None else "limit",
                    "signs": one.signs,
                    "verdict": one.verdict,
                }
            )
        if not rows:
            continue
        style = Marks(store, rows)
        name = _beside(first)[0]
        title_x = "time step [ms]" if name == "dt" else name.replace("_", " ")
        unit = "" if first.unit == "1" else f" [{first.unit}]"
        title_y = f"{first.axis.replace('_', ' ')}{unit}"
        x = logarithmic(alt.X, "beside", title_x, decades(row["beside"] for row in rows))
        spread = [row[key] for row in rows for key in ("held", "broke")]
        y = logarithmic(alt.Y, "held", title_y, decades(spread))
        told = [
            alt.Tooltip("engine:N"),
            alt.Tooltip("track:N"),
            alt.Tooltip("beside:Q", title=title_x, format=".4~g"),
            alt.Tooltip("held:Q", title="all starts held", format=".4~g"),
            alt.Tooltip("broke:Q", title="not all held", format=".4~g"),
            alt.Tooltip("signs:N", title="broke by"),
            alt.Tooltip("verdict:N"),
        ]
        channels = style.channels() | {"tooltip": told}
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
    """What of `where` is no number: 'continuous True'."""
    return ", ".join(word for word in one.where.split(", ") if word.endswith((" True", " False")))


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
