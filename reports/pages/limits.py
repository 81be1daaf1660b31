"""The page on limits: how far each engine goes along each axis, maps of two axes, and what helps where it breaks."""

from collections.abc import Mapping

from plumbline.harness.findings import tables
from plumbline.harness.findings.limits_found import searches
from plumbline.harness.findings.standing import axis_leads, reaches
from plumbline.harness.findings.tables.remedies import remedied
from plumbline.harness.store.store import Store
from plumbline.reports.charts.limit_maps import maps
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.tables.csv import sheet
from plumbline.reports.tables.limit_table import helped, in_words, lines, standings, tally
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
    in_family = [(title, {case["name"] for case in listed}) for title, listed in families(store)]
    groups = [(title, [line for line in shown if line.case in names]) for title, names in in_family]
    page = fill(
        "limits.html",
        store,
        title="Limits",
        names=[name for name in engines(store) if any(search.engine == name for search in plain)],
        groups=[(title, mine) for title, mine in groups if mine],
        standings=standings(axis_leads(reaches(plain))),
        maps=drawn,
        remedies=places,
        tally=counted,
        helped=helped(counted),
        in_words=in_words,
        cases=cases(store),
    )
    named = {name: tables.table(name) for name in ("limits", "farthest", "remedies")}
    sheets = {f"{name}.csv": sheet(table.columns, table.rows(store)) for name, table in named.items()}
    return {"limits.html": page} | sheets | {figure.path: figure for figure in drawn}


PAGE = Page(name="limits", title="Limits", order=12, render=render, concerns=concerns)
