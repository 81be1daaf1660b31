"""The page on limits: how far each engine goes along each axis, maps of two axes, and what helps where it breaks."""

from collections.abc import Mapping, Sequence

from plumbline.harness.findings.leads import axis_leads, reaches
from plumbline.harness.findings.limits_found import Search, searches
from plumbline.harness.findings.tables import farthest as farthest_table
from plumbline.harness.findings.tables import limits as limits_table
from plumbline.harness.findings.tables import remedies as remedies_table
from plumbline.harness.findings.tables.remedies import remedied
from plumbline.harness.store.store import Store
from plumbline.reports.charts.limit_maps import maps
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.tables.csv import sheet
from plumbline.reports.tables.limit_table import AxisLine, lines, standings
from plumbline.reports.tables.remedies import helped, in_words, tally
from plumbline.reports.words.catalogue import cases, engines, families


def concerns(store: Store) -> bool:
    """Only where limits were sought."""
    return bool(store.trials["members"].gt(1).any())


def render(store: Store) -> Mapping[str, Rendered]:
    """The page, its maps and its tables as CSV."""
    plain = [search for search in searches(store) if not search.remedied]
    places = remedied(store)
    counted = tally(places)
    shown, drawn = lines(store, plain), maps(store, plain)
    page = fill(
        "limits.html",
        store,
        title="Limits",
        names=_names(store, plain),
        groups=_groups(store, shown),
        standings=standings(axis_leads(reaches(plain))),
        maps=drawn,
        remedies=places,
        tally=counted,
        helped=helped(counted),
        in_words=in_words,
        cases=cases(store),
    )
    sheets = {
        "limits.csv": sheet(limits_table.TABLE.columns, limits_table.TABLE.rows(store)),
        "farthest.csv": sheet(farthest_table.TABLE.columns, farthest_table.TABLE.rows(store)),
        "remedies.csv": sheet(remedies_table.TABLE.columns, remedies_table.TABLE.rows(store)),
    }
    return {"limits.html": page} | sheets | {figure.path: figure for figure in drawn}


def _groups(store: Store, shown: Sequence[AxisLine]) -> list[tuple[str, list[AxisLine]]]:
    """The axes of each family of cases, families in their usual order."""
    groups = [(title, {case["name"] for case in listed}) for title, listed in families(store)]
    return [(title, mine) for title, names in groups if (mine := [line for line in shown if line.case in names])]


def _names(store: Store, shown: Sequence[Search]) -> list[str]:
    """The engines that were sought on."""
    return [name for name in engines(store) if any(search.engine == name for search in shown)]


PAGE = Page(name="limits", title="Limits", order=12, render=render, concerns=concerns)
