"""The page on limits: how far each engine goes along each axis, maps of two axes, and what helps where it breaks."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.limits_found import searches
from plumbline.harness.findings.standing import axis_leads, reaches
from plumbline.harness.findings.tables.remedies import remedied
from plumbline.harness.store.store import Store
from plumbline.reports.charts.limit_maps import maps
from plumbline.reports.html.template import filled_page
from plumbline.reports.tables.limit_table import helped, in_words, lines, standings, tally
from plumbline.reports.words.catalogue import engines, families


def concerns(store: Store) -> bool:
    """Only where limits were sought."""
    return bool(store.trials["members"].gt(1).any())


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    plain = [search for search in searches(store) if not search.remedied]
    places = remedied(store)
    counted = tally(places)
    shown, drawn = lines(store, plain), maps(store, plain)
    in_family = [(title, {case["name"] for case in listed}) for title, listed in families(store)]
    groups = [(title, [line for line in shown if line.case in names]) for title, names in in_family]
    return {
        "names": [name for name in engines(store) if any(search.engine == name for search in plain)],
        "groups": [(title, mine) for title, mine in groups if mine],
        "standings": standings(axis_leads(reaches(plain))),
        "maps": drawn,
        "remedies": places,
        "tally": counted,
        "helped": helped(counted),
        "in_words": in_words,
    }


PAGE = filled_page("limits", "Limits", 12, told, tables=("limits", "farthest", "remedies"), concerns=concerns)
