"""The page on many worlds: steps a second against their number, with error, memory and bits of the same settings beside."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.tables.throughput import throughputs
from plumbline.harness.store.store import Store
from plumbline.reports.charts.step_costs import charts
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.catalogue import titled


def concerns(store: Store) -> bool:
    """Only where worlds were stepped together in more than one number."""
    return len({row.worlds for row in throughputs(store)}) > 1


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    rows = throughputs(store)
    figures = charts(store, rows)
    return {
        "figures": figures,
        "rows": rows,
        "titles": {(row.case, row.where): titled(store, row.case, row.where) for row in rows},
        "batched": [name for name, engine in store.catalogue.get("engines", {}).items() if engine.get("batch")],
    }


PAGE = filled_page("throughput", "Many worlds", 21, told, tables=("throughput",), concerns=concerns)
