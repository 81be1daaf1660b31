"""The page on many worlds: steps a second against their number, with error, memory and bits of the same settings beside."""

from collections.abc import Mapping
from functools import partial

from plumbline.harness.findings.tables.throughput import TABLE, throughputs
from plumbline.harness.store.store import Store
from plumbline.reports.charts.step_costs import charts
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.tables.csv import sheet
from plumbline.reports.words.catalogue import setting_words, titled


def concerns(store: Store) -> bool:
    """Only where worlds were stepped together in more than one number."""
    return len({row.worlds for row in throughputs(store)}) > 1


def render(store: Store) -> Mapping[str, Rendered]:
    """The page, its charts and its rows as CSV."""
    rows = throughputs(store)
    figures = charts(store, rows)
    page = fill(
        "throughput.html",
        store,
        title="Many worlds",
        figures=figures,
        rows=rows,
        titles={(row.case, row.where): titled(store, row.case, row.where) for row in rows},
        batched=[name for name, engine in store.catalogue.get("engines", {}).items() if engine.get("batch")],
        setting_of=partial(setting_words, store),
    )
    return {"throughput.html": page, "throughput.csv": sheet(TABLE.columns, map(TABLE.flat, rows))} | {
        figure.path: figure for figure in figures
    }


PAGE = Page(name="throughput", title="Many worlds", order=21, render=render, concerns=concerns)
