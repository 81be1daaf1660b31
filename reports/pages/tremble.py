"""The page on trembling: how strongly each engine's standing machine vibrates, and the cause that its runs prove."""

from collections.abc import Mapping

from plumbline.harness.findings.tables.tremble import CHANGES, CURED, findings
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.words.catalogue import cases

HEADS = {
    "iterations": "more iterations",
    "law": "other law",
    "softer": "softer drives",
    "step": "shorter step",
    "product": "both at one k dt²",
}
"""The changes in the words of a table's head."""


def concerns(store: Store) -> bool:
    """Only where a cause may be told: without more iterations nothing but that all is still can be proved."""
    return any("iterations" in found.shares for found in findings(store))


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    page = fill(
        "tremble.html",
        store,
        title="Tremble",
        found=findings(store),
        cases=cases(store),
        changes=CHANGES,
        heads=HEADS,
        cured=CURED,
    )
    return {"tremble.html": page}


PAGE = Page(name="tremble", title="Tremble", order=30, render=render, concerns=concerns)
