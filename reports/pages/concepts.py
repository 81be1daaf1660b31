"""The index of concepts: from a word of a first course to its case, its chart and the file of our engine that has it."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from reports.charts import step_charts
from reports.concepts import book, indexed
from reports.contents import cases
from reports.own_scenes import by_case
from reports.page import Page
from reports.template import fill

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["PAGE"]


def render(store: "Store") -> Mapping[str, str]:
    """The page."""
    known = {name: case for name, case in cases(store).items() if name not in by_case(store)}
    page = fill("concepts.html", store, title="Concepts", chapters=book(), cases=known, charts=step_charts(store))
    return {"concepts.html": page}


PAGE = Page(name="concepts", title="Concepts", order=95, render=render, listed=False, concerns=indexed)
