"""The page on limits: how far each engine goes along each axis, maps of two axes, and what helps where it breaks."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from harness.findings.leads import axis_leads, reaches
from harness.findings.limits_found import Search, searches
from harness.findings.tables import farthest as farthest_table
from harness.findings.tables import limits as limits_table
from harness.findings.tables import remedies as remedies_table
from harness.findings.tables.remedies import remedied
from reports.contents import engines
from reports.page import Page
from reports.reach import lines, maps, standings, tally
from reports.sheet import sheet
from reports.template import fill

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["PAGE"]


def concerns(store: "Store") -> bool:
    """Only where limits were sought."""
    return bool(store.trials["members"].gt(1).any())


def render(store: "Store") -> Mapping[str, str]:
    """The page, its maps and its tables as CSV."""
    plain = [search for search in searches(store) if not search.remedied]
    helped = remedied(store)
    shown, drawn = lines(store, plain), maps(store, plain)
    page = fill(
        "limits.html",
        store,
        title="Limits",
        names=_names(store, plain),
        lines=shown,
        standings=standings(axis_leads(reaches(plain))),
        maps=drawn,
        remedies=helped,
        tally=tally(helped),
        helped=remedies_table.sentences(remedies_table.rows(store))[:6],
    )
    sheets = {
        "limits.csv": sheet(limits_table.COLUMNS, limits_table.rows(store)),
        "farthest.csv": sheet(farthest_table.COLUMNS, farthest_table.rows(store)),
        "remedies.csv": sheet(remedies_table.COLUMNS, remedies_table.rows(store)),
    }
    return {"limits.html": page} | sheets | {figure.path: figure.svg for figure in drawn}


def _names(store: "Store", shown: Sequence[Search]) -> list[str]:
    """The engines that were sought on, the yardstick last: on a narrow screen the first columns are read."""
    known = engines(store)
    return sorted(
        (name for name in known if any(search.engine == name for search in shown)), key=lambda name: bool(known[name]["ours"])
    )


PAGE = Page(name="limits", title="Limits", order=12, render=render, concerns=concerns)
