"""The page on effects: what each costs, what its absence does, and whether each scene calls for exactly what it needs."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.case.alteration import EVERYTHING
from plumbline.harness.findings.effects_audit import audit, savings
from plumbline.harness.findings.tables.effects import verdicts
from plumbline.harness.store.store import Store
from plumbline.reports.charts.unneeded_effects import matrix, savings_chart
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.catalogue import engines, titles


def concerns(store: Store) -> bool:
    """Only where effects were switched."""
    return bool(store.trials["alteration"].str.contains(EVERYTHING, regex=False).any())


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    judged = verdicts(store)
    figure = savings_chart(store, judged)
    return {
        "names": [name for name in engines(store) if any(verdict.engine == name for verdict in judged)],
        "savings": savings(judged),
        "figure": figure,
        "audit": audit(judged),
        "titles": titles(store),
        "matrix": matrix(store, judged),
        "found": [verdict for verdict in judged if verdict.verdict != EVERYTHING],
    }


PAGE = filled_page("effects", "Effects", 14, told, tables=("effects",), concerns=concerns)
