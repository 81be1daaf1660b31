"""The glossary: what the words of pages, tables and help texts mean."""

from collections.abc import Mapping

from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.words.glossary import glossary


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    return {"glossary.html": fill("glossary.html", store, title="Glossary", entries=glossary())}


PAGE = Page(name="glossary", title="Glossary", order=96, render=render, concerns=lambda _: bool(glossary()))
