"""An answer as flat rows: its ranking, and the evidence that it leans on, with its runs."""

from collections.abc import Mapping
from typing import Any

from plumbline.harness.findings.columns import Column, plain
from plumbline.harness.findings.parameter_words import step_in_words
from plumbline.harness.findings.selection.choose import Selection
from plumbline.harness.findings.selection.wish import CRITERIA

COLUMNS = ("criterion", "case", "engine", "value", "low", "high", "says", "track", "dt", "substeps", "trial")
"""value: 1 is as good as is asked, 0 is of no use, with its interval low..high; says: the figure behind it. dt [s], taken in
substeps."""


def rows(answer: Selection) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    flat = []
    for (criterion, case, engine), datum in sorted(answer.evidence.table.items()):
        row = {name: getattr(datum, name, None) for name in COLUMNS}
        substeps = None if datum.dt is None else datum.substeps
        flat.append(row | {"criterion": criterion, "case": case, "engine": engine, "substeps": substeps})
    return flat


def ranking(answer: Selection) -> list[dict[str, Any]]:
    """One an engine: its entry, or why it is left out; of one that nobody stands beside no share, but why it is alone."""
    rows: list[dict[str, Any]] = []
    for entry in answer.rank.places if answer.rank is not None else ():
        rows.append(
            {
                "engine": entry.engine,
                "place": entry.number,
                "first": None if answer.alone else entry.first,
                "speed": answer.evidence.speed(entry.engine),
                "error": answer.evidence.error(entry.engine),
                "within": answer.evidence.within(entry.engine)[0],
                "judged": answer.evidence.within(entry.engine)[1],
                "score": entry.score,
                "low": entry.low,
                "high": entry.high,
                "track": answer.evidence.tracks[entry.engine],
                **{criterion: entry.by_criterion.get(criterion) for criterion in CRITERIA},
                "alone": answer.alone or None,
                "left_out": None,
                "case": None,
                "trial": None,
            }
        )
    blank = dict.fromkeys(
        rows[0]
        if rows
        else ("place", "first", "speed", "error", "within", "judged", "score", "low", "high", "track", *CRITERIA, "alone")
    )
    for drop in answer.dropped:
        why = f"{drop.requirement}: {drop.value}"
        rows.append({**blank, "engine": drop.engine, "left_out": why, "case": drop.case or None, "trial": drop.trial or None})
    return rows


def _step(row: Mapping[str, Any]) -> str:
    return "" if row["dt"] is None else step_in_words(row["dt"], row["substeps"])


SHOWN = (
    *plain("criterion", "case", "engine", "of 1=value:.2f", "because=says", "settings=track"),
    Column("step", _step),
    Column("trial", "trial"),
)
"""What a terminal has room for."""
