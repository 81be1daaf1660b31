"""The page Trends: what a history remembers: regressions first, then prices and answers of every case and engine."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from shlex import quote

from plumbline.harness.history.regressions import Trends
from plumbline.harness.history.steps import Series
from plumbline.harness.store.disk import make_folder, write_atomically
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.marks import looks
from plumbline.reports.charts.trends import TrendMiniature, TrendPanel, engine_panels, index_chart, miniature, panels
from plumbline.reports.html.drawing import Drawing
from plumbline.reports.html.policy import copy_style, guarded
from plumbline.reports.html.template import environment
from plumbline.reports.html.written import SCRIPT, NotWritten, WrittenReport, picture_file, script_file
from plumbline.reports.words.catalogue import FAMILIES

PAGE = "index.html"
_STATES = {"open": "failed", "acknowledged": "interrupted", "mended": "passed", "another version": "unavailable"}
_MOST_CHARTS, _MOST_ROWS, _MOST_ANSWERS = 8, 300, 1000
"""Charts of changes, those that stand first, and rows of a list and of a table; `plumbline history trends --json` has all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Case:
    """A row of miniatures. Terms: changed: does any of them have a step?"""

    title: str
    miniatures: tuple[TrendMiniature, ...]
    changed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class _Family:
    title: str
    cases: tuple[_Case, ...]

    @property
    def changed(self) -> int:
        """How many of its cases have a step."""
        return sum(case.changed for case in self.cases)


def trends_page(trends: Trends) -> tuple[str, tuple[Figure, ...]]:
    """The page as text, with its policy, and the charts whose pictures lie beside it."""
    every = panels(trends)
    by_engine = engine_panels(trends)
    chosen = looks(panel.engine for panel in by_engine)
    whole = index_chart(by_engine, trends.nights, chosen, "Each engine as a whole")
    figures = tuple(figure for figure in (whole, *_changed_charts(trends, every, by_engine)) if figure is not None)
    page = (
        environment()
        .get_template("trends.html")
        .render(
            trends=trends,
            figures=figures,
            families=_families(every),
            states=_STATES,
            rows=trends.regressions[:_MOST_ROWS],
            better=[one for one in trends.dated if one.first.sense == "better"][:_MOST_ROWS],
            segments=_segments(trends),
            ack=("plumbline history ack", f"--history {quote(trends.root)}"),
            answers=_answers(trends)[:_MOST_ANSWERS],
        )
    )
    return guarded(page), figures


def _changed_charts(trends: Trends, every: Sequence[TrendPanel], by_engine: Sequence[TrendPanel]) -> list[Figure | None]:
    """A chart for each case on an engine that has a step, those that stand first, then the newest."""
    standing = {(one.first.case, one.first.engine): one for one in trends.dated if one.first.kind == "price"}
    chosen = looks(panel.engine for panel in by_engine)

    def weight(panel: TrendPanel) -> tuple[bool, int]:
        dated = standing.get((panel.case, panel.engine))
        return dated is None or dated.state != "open", -max(step.night for step in panel.steps)

    own = (panel for panel in (*by_engine, *every) if any(step.change.case == panel.case for step in panel.steps))
    stepped = sorted(own, key=weight)
    return [
        index_chart([panel], trends.nights, chosen, f"{panel.case_title} on {panel.engine_title}")
        for panel in stepped[:_MOST_CHARTS]
    ]


def _families(every: Sequence[TrendPanel]) -> list[_Family]:
    chosen = looks(dict.fromkeys(panel.engine for panel in every))
    cases: dict[str, list[TrendPanel]] = {}
    for panel in every:
        cases.setdefault(panel.case, []).append(panel)
    families: dict[str, list[_Case]] = {}
    for name, mine in cases.items():
        made = tuple(miniature(panel, chosen[panel.engine].colour) for panel in mine)
        family = name.replace(":", "_").split("_")[0]
        families.setdefault(family, []).append(
            _Case(title=mine[0].case_title, miniatures=made, changed=any(panel.steps for panel in mine))
        )
    order = list(FAMILIES)
    ranked = sorted(families, key=lambda name: (order.index(name) if name in order else len(order), name))
    return [_Family(title=FAMILIES.get(name, name), cases=tuple(families[name])) for name in ranked]


def _answers(trends: Trends) -> list[tuple[Series, str, float, float, int]]:
    """Errors and limits, those first that changed last: each with the night since which it is as it is, its first and last
    value, and how many nights changed its bits or value."""
    rows = []
    for one in trends.series:
        if one.kind == "price":
            continue
        there = [n for n, trial in enumerate(one.trials) if trial]
        changed = [b for a, b in pairwise(there) if _otherwise(one, a, b)]
        since = trends.nights[changed[-1] if changed else there[0]].stamp
        rows.append((one, since, float(one.values[there[0]]), float(one.values[there[-1]]), len(changed)))
    return sorted(rows, key=lambda row: row[1], reverse=True)


def _otherwise(one: Series, a: int, b: int) -> bool:
    """Are two nights of a series other answers?"""
    return one.hashes[a] != one.hashes[b] or (not one.hashes[b] and one.values[a] != one.values[b])


def _segments(trends: Trends) -> list[tuple[str, str]]:
    """Nights on which a machine or a version became another, in words."""
    made = []
    for before, now in pairwise(trends.nights):
        words = []
        if now.machine != before.machine:
            words.append(f"machine {now.machine} ({now.processor})")
        words += [
            f"{trends.called(engine)} {before.versions[engine]}, now {version}"
            for engine, version in now.versions.items()
            if engine in before.versions and before.versions[engine] != version
        ]
        if words:
            made.append((now.stamp, "; ".join(words)))
    return made


def write_trends(trends: Trends, folder: Path) -> WrittenReport:
    """Write the page, its style and its pictures into a folder; it needs no network and no run folder."""
    failures: dict[str, NotWritten] = {}
    page, figures = trends_page(trends)
    make_folder(folder / "charts")
    copy_style(folder, "vega-licences.txt")
    write_atomically(folder / SCRIPT, script_file(failures).encode())
    with Drawing(folder) as beside:
        for path, drawn in [(figure.path, beside.ask(figure)) for figure in figures]:
            write_atomically(folder / path, str(picture_file(path, drawn, failures)).encode())
    write_atomically(folder / PAGE, page.encode("utf-8", "backslashreplace"))
    return WrittenReport(folder / PAGE, tuple(failures.values()))
