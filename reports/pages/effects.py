"""The page on effects: what each costs, what its absence does, and whether each scene calls for exactly what it needs."""

from collections.abc import Mapping

from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.findings.effects_audit import audit, savings
from plumbline.harness.findings.tables.effects import TABLE, verdicts
from plumbline.harness.store.store import Store
from plumbline.reports.charts.unneeded_effects import matrix, savings_chart
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.tables.csv import sheet
from plumbline.reports.words.catalogue import engines, titles


def concerns(store: Store) -> bool:
    """Only where effects were switched."""
    return bool(store.trials["alteration"].str.contains(EVERYTHING, regex=False).any())


def render(store: Store) -> Mapping[str, Rendered]:
    """The page, its chart and its table as CSV."""
    judged = verdicts(store)
    figure = savings_chart(store, judged)
    page = fill(
        "effects.html",
        store,
        title="Effects",
        names=[name for name in engines(store) if any(verdict.engine == name for verdict in judged)],
        savings=savings(judged),
        figure=figure,
        audit=audit(judged),
        titles=titles(store),
        matrix=matrix(store, judged),
        found=[verdict for verdict in judged if verdict.verdict != EVERYTHING],
    )
    sheets = {"effects.csv": sheet(TABLE.columns, map(TABLE.flat, judged))}
    return {"effects.html": page} | sheets | ({figure.path: figure} if figure is not None else {})


PAGE = Page(name="effects", title="Effects", order=14, render=render, concerns=concerns)
