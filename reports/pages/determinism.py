"""The page on determinism: which repetitions give the same bits, and where those part that do not."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.tables.determinism import FIRST, repetitions
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.catalogue import engines


def concerns(store: Store) -> bool:
    """Only where runs were repeated."""
    return bool(store.trials["alteration"].str.contains("every_step", regex=False).any())


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    rows = repetitions(store)
    ways = list(dict.fromkeys(row.way for row in rows if row.way not in (FIRST, "nudged") and not row.variables))
    libraries = dict(sorted({(row.way, row.variables) for row in rows if row.variables}))
    counted = {
        (engine, way): [row.verdict for row in rows if row.engine == engine and row.way == way]
        for engine in dict.fromkeys(row.engine for row in rows)
        for way in (*ways, *libraries)
    }
    growth = [row for row in rows if row.way == "nudged" and row.doubles_in is not None]
    return {
        "names": [name for name in engines(store) if any(row.engine == name for row in rows)],
        "ways": ways,
        "libraries": libraries,
        "counted": counted,
        "growth": growth,
        "found": rows,
    }


PAGE = filled_page("determinism", "Determinism", 16, told, tables=("determinism",), concerns=concerns)
