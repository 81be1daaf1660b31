"""The glossary: what the words of pages, tables and help texts mean."""

from collections.abc import Mapping
from itertools import groupby

from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.words.glossary import glossary


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    sections = [(title, list(group)) for title, group in groupby(glossary(), key=lambda entry: entry.section)]
    return {"glossary.html": fill("glossary.html", store, title="Glossary", sections=sections)}


PAGE = Page(name="glossary", title="Glossary", order=96, render=render, concerns=lambda _: bool(glossary()))
