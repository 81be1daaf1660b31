"""The nights of a history as rows: when, on what, how much was recalled and computed, what changed, what lies on the disk."""

from typing import Any

import pandas as pd

from plumbline.harness.history.budget import bytes_of
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.readings import versions_of
from plumbline.harness.history.sentences import outcomes_in_short
from plumbline.harness.store.journal import DamagedFile

COLUMNS = (
    "night", "state", "machine", "versions", "answers", "recalled", "computed", "again", "disagreements", "clocked", "left_out",
    "worse", "better", "seconds", "megabytes", "outcomes",
)  # fmt: skip


def counted(trials: pd.DataFrame, disagreements: int = 0) -> dict[str, int]:
    """How many answers the table of a night has: all; computed, recalled, computed again, and otherwise then; clocked."""
    known, again = int((trials["recalled"] != "").sum()), int((trials["again"] != "").sum())
    counts = {"answers": len(trials), "computed": len(trials) - known, "recalled": known, "again": again}
    return counts | {"disagreements": disagreements, "clocked": int((trials["cpu_per_unit"] > 0).sum())}


def rows(history: History) -> tuple[list[dict[str, Any]], list[DamagedFile]]:
    """One for each night, the earliest first, with COLUMNS; and what is left out. Raises: StoreError."""
    each = [_row(night) if isinstance(night, Night) else night for night in history.each()]
    return [row for row in each if isinstance(row, dict)], [error for error in each if isinstance(error, DamagedFile)]


def _row(night: Night) -> dict[str, Any]:
    plan, store = night.plan, night.store()
    told = plan.get("told", ())
    # What a night does not say that is under way, or of an older version, is read off its records.
    counts = plan if "clocked" in plan else counted(store.trials)
    versions = plan["versions"] if "versions" in plan else versions_of(store)
    return {
        "night": night.stamp,
        "state": "whole" if plan.get("complete") else "unfinished",
        "machine": f"{store.machine.get('processor', '')} x{store.machine.get('cores', '?')}",
        "versions": ", ".join(f"{engine} {version}" for engine, version in sorted(versions.items())),
        **{name: counts[name] for name in ("answers", "recalled", "computed", "again", "disagreements", "clocked")},
        "left_out": len(plan.get("left_out", ())),
        "worse": sum(row["regression"] for row in told),
        "better": sum(row["sense"] == "better" for row in told),
        "seconds": plan.get("seconds", {}).get("whole"),
        "megabytes": bytes_of([night.folder], shared=False) / 2**20,
        "outcomes": outcomes_in_short(plan).removeprefix("outcomes: "),
    }
