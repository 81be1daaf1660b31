"""The evidence that an answer leans on: each engine in each case by each criterion, with its run."""

from typing import Any

from plumbline.harness.findings.columns import Column, Row, plain
from plumbline.harness.findings.selection.choose import Answer
from plumbline.harness.findings.steps_taken import step_in_words

COLUMNS = ("criterion", "case", "engine", "value", "low", "high", "says", "track", "dt", "substeps", "trial")
"""value: 1 is as good as is asked, 0 is of no use, with its interval low..high; says: the figure behind it. dt [s], taken in
substeps."""


def rows(answer: Answer) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    flat = []
    for (criterion, case, engine), datum in sorted(answer.evidence.table.items()):
        row = {name: getattr(datum, name, None) for name in COLUMNS}
        substeps = None if datum.dt is None else datum.substeps
        flat.append(row | {"criterion": criterion, "case": case, "engine": engine, "substeps": substeps})
    return flat


def _step(row: Row) -> str:
    return "" if row["dt"] is None else step_in_words(row["dt"], row["substeps"])


SHOWN = (
    *plain("criterion", "case", "engine"),
    Column("of 1", "value", ".2f"),
    Column("because", "says"),
    Column("settings", "track"),
    Column("step", _step),
    Column("trial", "trial"),
)
"""What a terminal has room for."""
