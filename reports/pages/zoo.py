"""The page on a zoo of robots: which go in, into which engine, what is left out, who agrees, at what cost, and why not."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.agreement.costs import WITHIN
from plumbline.harness.findings.tables import zoo as zoo_table
from plumbline.harness.store.store import Store
from plumbline.harness.store.zoo_record import entries
from plumbline.reports.html.template import filled_page
from plumbline.reports.pictures.case_pictures import sight
from plumbline.reports.tables.own_scenes import STAGES, inside, outside, waiting
from plumbline.reports.words.catalogue import engines
from plumbline.reports.words.status import NOT_RUN, VERDICTS


def concerns(store: Store) -> bool:
    """Only of a folder that robots were taken into by a zoo."""
    return next(entries(store.folder), None) is not None


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    rows = zoo_table.in_zoo(store)
    robots = inside(store)
    return {
        "words": zoo_table.TABLE.sentences(rows),
        "robots": robots,
        "thumbs": {robot.about.case: sight(store, robot.about.case).thumb for robot in robots if robot.about.case},
        "asked": [name for name in engines(store) if any(name in robot.cells for robot in robots)],
        "waiting": waiting(store),
        "outside": outside(store),
        "stages": STAGES,
        "within": WITHIN,
        "meanings": {**VERDICTS, NOT_RUN.name: NOT_RUN},
    }


PAGE = filled_page("zoo", "Zoo", 8, told, tables=("zoo",), concerns=concerns)
