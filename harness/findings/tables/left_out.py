"""What the budget of a night left out: experiment and case, how much that is, why, and which night saw it last."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.columns import Column, Table, plain


def _sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """How much in all."""
    if not rows:
        return ["Nothing was left out."]
    return [f"{len(rows)} cases of experiments were left out, {sum(row['trials'] for row in rows)} trials."]


TABLE = Table(
    holds="experiment case trials why last_seen foreseen",
    objects=lambda store: store.night.get("left_out", ()),  # none of a run that is no night of a history
    shown=(
        *plain("experiment", "case", "trials", "why"),
        Column("last seen", lambda row: row.get("last_seen") or "never"),
        Column("foreseen", lambda row: "unknown" if row.get("foreseen") is None else f"{row['foreseen']:.0f} s"),
    ),
    sentences=_sentences,
)
