"""The page on dominance: which changes of one knob beat 'tuned', the adapters' reasons, and what became of the rest."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.tables.dominance import DOMINATED, EXCUSED, IDLE, changes
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.catalogue import engines


def concerns(store: Store) -> bool:
    """Only if knobs were turned to beat a track."""
    asked = store.study.get("experiments", [])
    return any(isinstance(one, dict) and one.get("dominance") for one in asked if isinstance(asked, list)) and bool(
        changes(store)
    )


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    found = changes(store)
    better = [change for change in found if change.verdict in (DOMINATED, EXCUSED)]
    return {
        "names": [name for name in engines(store) if any(change.engine == name for change in found)],
        "better": better,
        "others": [change for change in found if change.verdict not in (DOMINATED, EXCUSED)],
        "counts": {
            (name, verdict): sum(change.count for change in found if change.engine == name and change.verdict == verdict)
            for name in engines(store)
            for verdict in {change.verdict for change in found}
        },
        "verdicts": sorted({change.verdict for change in found} - {DOMINATED, EXCUSED, IDLE}),
        "dominated": DOMINATED,
        "excused": EXCUSED,
        "idle": IDLE,
    }


PAGE = filled_page("dominance", "Dominance", 15, told, tables=("dominance",), concerns=concerns)
