"""What the budget of a night left out: experiment and case, how much that is, why, and which night saw it last."""

from collections.abc import Sequence

from plumbline.harness.findings.columns import Column, Row, Table, plain

COLUMNS = ("experiment", "case", "trials", "why", "last_seen", "foreseen")


def _sentences(rows: Sequence[Row]) -> list[str]:
    """How much in all."""
    if not rows:
        return ["Nothing was left out."]
    return [f"{len(rows)} cases of experiments were left out, {sum(row['trials'] for row in rows)} trials."]


TABLE = Table(
    columns=COLUMNS,
    objects=lambda store: store.night.get("left_out", ()),  # none of a run that is no night of a history
    row=lambda row: {name: row.get(name) for name in COLUMNS},
    shown=(
        *plain("experiment", "case", "trials", "why"),
        Column("last seen", lambda row: row["last_seen"] or "never"),
        Column("foreseen", lambda row: "unknown" if row["foreseen"] is None else f"{row['foreseen']:.0f} s"),
    ),
    sentences=_sentences,
)
