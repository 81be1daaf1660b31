"""The nights of a history as rows: when, on what, how much was recalled and computed, what changed, what lies on the disk."""

from collections.abc import Iterator
from typing import Any

from plumbline.harness.history.budget import bytes_of
from plumbline.harness.history.folder import History, Night

COLUMNS = (
    "night", "state", "machine", "versions", "answers", "recalled", "computed", "again", "disagreements", "clocked", "left_out",
    "worse", "better", "seconds", "megabytes",
)  # fmt: skip


def rows(history: History) -> Iterator[dict[str, Any]]:
    """One for each night, the earliest first, with COLUMNS. Raises: StoreError."""
    for night in history.nights():
        yield _row(night)


def _row(night: Night) -> dict[str, Any]:
    plan, store = night.plan, night.store()
    trials = store.trials
    asked = trials[trials["status"] != "unavailable"]
    versions = {str(row.engine): str(row.engine_version) for row in asked.itertuples()}
    told = plan.get("told", ())
    return {
        "night": night.stamp,
        "state": "whole" if night.whole else "unfinished",
        "machine": f"{store.machine.get('processor', '')} x{store.machine.get('cores', '?')}",
        "versions": ", ".join(f"{engine} {version}" for engine, version in sorted(versions.items())),
        "answers": len(trials),
        "recalled": int((trials["recalled"] != "").sum()),
        "computed": int((trials["recalled"] == "").sum()),
        "again": int((trials["again"] != "").sum()),
        "disagreements": int(plan.get("disagreements", 0)),
        "clocked": int((trials["cpu_per_unit"] > 0).sum()),
        "left_out": len(plan.get("left_out", ())),
        "worse": sum(row["regression"] for row in told),
        "better": sum(row["sense"] == "better" for row in told),
        "seconds": plan.get("seconds", {}).get("whole"),
        "megabytes": bytes_of([night.folder], shared=False) / 2**20,
    }
