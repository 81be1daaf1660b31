"""The index of concepts: from a word of a first course to its case, its chart and the file of our engine that has it."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import step_charts
from plumbline.reports.html.template import filled_page
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.words.catalogue import cases
from plumbline.reports.words.glossary import book, indexed


def told(store: Store) -> Mapping[str, Any]:
    """Chapters, cases and charts of other pages."""
    known = {name: case for name, case in cases(store).items() if name not in by_case(store)}
    return {"chapters": book(), "cases": known, "charts": step_charts(store)}


PAGE = filled_page("concepts", "Concepts", 95, told, listed=False, concerns=indexed)
