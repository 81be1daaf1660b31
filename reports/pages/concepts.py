"""The index of concepts: from a word of a first course to its case, its chart and the file of our engine that has it."""

from collections.abc import Mapping

from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import step_charts
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.words.catalogue import cases
from plumbline.reports.words.glossary import book, indexed


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    known = {name: case for name, case in cases(store).items() if name not in by_case(store)}
    page = fill("concepts.html", store, title="Concepts", chapters=book(), cases=known, charts=step_charts(store))
    return {"concepts.html": page}


PAGE = Page(name="concepts", title="Concepts", order=95, render=render, listed=False, concerns=indexed)
