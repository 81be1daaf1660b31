"""Maps of limits: a chart of each axis that was sought at several values of something else."""

from collections.abc import Sequence
from typing import Any

from plumbline.harness.findings.limits_found import CONSTANT, Search
from plumbline.harness.findings.parameter_words import STEP, axis_title, in_words
from plumbline.harness.store.store import Store
from plumbline.reports.charts.figure import Figure, tabled
from plumbline.reports.charts.grammar import Row, chart, hovering
from plumbline.reports.charts.marks import POINT, Marks, at_values, decades, finished, logarithmic
from plumbline.reports.tables.limit_table import VERDICTS, mapped, signs
from plumbline.reports.words.catalogue import cases, labels
from plumbline.reports.words.text import amount, slug

ENDS = ("held", "broke", "by=signs", "verdict")
"""Of the table below a map: its last columns."""


def maps(store: Store, searches: Sequence[Search]) -> list[Figure]:
    """A chart for each case that was sought at several values of something else."""
    return [figure for name, group in mapped(searches) for figure in _map(store, name, group)]


def _map(store: Store, name: str, group: Sequence[Search]) -> list[Figure]:
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
                or search.verdict in ("unsupported", "unavailable", CONSTANT)
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
                    "signs": signs(search, why=True),
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
        shown = hovering(
            "engine:N",
            "track:N",
            ("beside:Q", title_x, ".3~g"),
            ("held:Q", "all starts held", ".3~g"),
            ("broke:Q", "not all held", ".3~g"),
            ("signs:N", "broke by"),
            "verdict:N",
        )
        layers = [
            chart(rows)
            .marked("line", strokeWidth=1.6)
            .encode(x=x, y=y, detail="series:N", color=style.colour(), strokeDash=style.dash()),
            chart([row for row in rows if row["mark"] == "limit"])
            .marked("rule", strokeWidth=3, opacity=0.35)
            .encode(x=x, y=y, y2="broke:Q", color=style.colour()),
            chart(rows).marked("point", **POINT | {"size": 60}).encode(x=x, y=y, **style.channels(shown)),
        ]
        title = cases(store)[first.case]["title"] + (f", {other}" if other else "")
        figures.append(
            Figure(
                f"map-{slug(first.experiment)}-{slug(first.case)}{'-' + slug(other) if other else ''}",
                title,
                f"The hardest {title_y} that every start held.",
                finished(layers, height=190),
                *tabled(rows, "engine", "setting=track", (title_x, lambda row: amount(row["beside"])), *ENDS),
                f"Bars span to the first that not all held. At {amount(first.easy)} nothing harder than the start of the axis "
                f"held, at {amount(first.extreme)} its end.",
            )
        )
    return figures


def _rest(search: Search, name: str) -> str:
    """What stands beside the axis and that number, in words: 'continuous on'."""
    return in_words([(other, value) for other, value in search.beside if other != name])
