"""The page on dominance: which changes of one knob beat 'tuned', the adapters' reasons, and what became of the rest."""

from collections.abc import Mapping

from plumbline.harness.findings.tables.dominance import DOMINATED, EXCUSED, IDLE, TABLE, changes
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.tables.csv import sheet
from plumbline.reports.words.catalogue import cases, engines


def concerns(store: Store) -> bool:
    """Only if knobs were turned to beat a track."""
    asked = store.study.get("experiments", [])
    return any(isinstance(one, dict) and one.get("dominance") for one in asked if isinstance(asked, list)) and bool(
        changes(store)
    )


def render(store: Store) -> Mapping[str, Rendered]:
    """The page and its table as CSV."""
    found = changes(store)
    better = [change for change in found if change.verdict in (DOMINATED, EXCUSED)]
    page = fill(
        "dominance.html",
        store,
        title="Dominance",
        names=[name for name in engines(store) if any(change.engine == name for change in found)],
        cases=cases(store),
        better=better,
        others=[change for change in found if change.verdict not in (DOMINATED, EXCUSED)],
        counts={
            (name, verdict): sum(change.count for change in found if change.engine == name and change.verdict == verdict)
            for name in engines(store)
            for verdict in {change.verdict for change in found}
        },
        verdicts=sorted({change.verdict for change in found} - {DOMINATED, EXCUSED, IDLE}),
        dominated=DOMINATED,
        excused=EXCUSED,
        idle=IDLE,
    )
    return {
        "dominance.html": page,
        "dominance.csv": sheet(TABLE.columns, map(TABLE.flat, found)),
    }


PAGE = Page(name="dominance", title="Dominance", order=15, render=render, concerns=concerns)
