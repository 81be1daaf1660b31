"""The page on trembling: how strongly each engine's standing machine vibrates, and the cause that its runs prove."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.tables.tremble import CHANGES, CURED, findings
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.called import WORDS

HEADS = WORDS["changes"]
"""The changes in the words of a table's head."""


def concerns(store: Store) -> bool:
    """Only where a cause may be told: without more iterations nothing but that all is still can be proved."""
    return any("iterations" in found.shares for found in findings(store))


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    return {"found": findings(store), "changes": CHANGES, "heads": HEADS, "cured": CURED}


PAGE = filled_page("tremble", "Tremble", 30, told, concerns=concerns)
