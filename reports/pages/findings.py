"""The page on findings: what is wrong, or a trap, in the engines of a run, each with the script that shows it."""

from collections.abc import Mapping

from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.words.catalogue import cases
from plumbline.reports.words.known_findings import by_engine


def concerns(store: Store) -> bool:
    """Only where something is known of an engine of the run."""
    return bool(by_engine(store))


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    groups = by_engine(store)
    versions = store.trials.groupby("engine")["engine_version"].first().astype(str).to_dict()
    page = fill("findings.html", store, title="Findings", groups=groups, cases=cases(store), versions=versions)
    return {"findings.html": page}


PAGE = Page(name="findings", title="Findings", order=80, render=render, concerns=concerns)
