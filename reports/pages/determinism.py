"""The page on determinism: which repetitions give the same bits, and where those part that do not."""

from collections.abc import Mapping

from plumbline.harness.findings.tables.determinism import FIRST, TABLE, repetitions
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.tables.csv import sheet
from plumbline.reports.words.catalogue import engines


def concerns(store: Store) -> bool:
    """Only where runs were repeated."""
    return bool(store.trials["alteration"].str.contains("every_step", regex=False).any())


def render(store: Store) -> Mapping[str, str]:
    """The page and its table as CSV."""
    rows = repetitions(store)
    ways = list(dict.fromkeys(row.way for row in rows if row.way not in (FIRST, "nudged") and not row.variables))
    libraries = dict(sorted({(row.way, row.variables) for row in rows if row.variables}))
    counted = {
        (engine, way): [row.verdict for row in rows if row.engine == engine and row.way == way]
        for engine in dict.fromkeys(row.engine for row in rows)
        for way in (*ways, *libraries)
    }
    growth = [row for row in rows if row.way == "nudged" and row.doubles_in is not None]
    page = fill(
        "determinism.html",
        store,
        title="Determinism",
        names=[name for name in engines(store) if any(row.engine == name for row in rows)],
        ways=ways,
        libraries=libraries,
        counted=counted,
        growth=growth,
        found=rows,
    )
    return {
        "determinism.html": page,
        "determinism.csv": sheet(TABLE.columns, map(TABLE.flat, rows)),
    }


PAGE = Page(name="determinism", title="Determinism", order=16, render=render, concerns=concerns)
