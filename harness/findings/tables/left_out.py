"""What the budget of a night left out: experiment and case, how much that is, why, and which night saw it last."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.store.store import Store

COLUMNS = ("experiment", "case", "trials", "why", "last_seen", "foreseen")


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS; none of a run that is no night of a history. Raises: DamagedFile."""
    return [{name: row.get(name) for name in COLUMNS} for row in store.night.get("left_out", ())]


BRIEF = ("experiment", "case", "trials", "why", "last seen", "foreseen")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    foreseen = "unknown" if row["foreseen"] is None else f"{row['foreseen']:.0f} s"
    return [row["experiment"], row["case"], row["trials"], row["why"], row["last_seen"] or "never", foreseen]


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """How much in all."""
    if not rows:
        return ["Nothing was left out."]
    return [f"{len(rows)} cases of experiments were left out, {sum(row['trials'] for row in rows)} trials."]
