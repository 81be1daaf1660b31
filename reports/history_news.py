"""What a night of a history says of what changed since each answer was last seen, from the files beside its report."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.trial_rows import is_file
from reports.what_changed import PAGE

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["HistoryNews", "history_news"]

SHOWN = 4


@dataclass(frozen=True, slots=True)
class HistoryNews:
    """Terms: worse, better: how many changes; sentences: of the worse ones first, heaviest first; page: its address."""

    worse: int
    better: int
    sentences: Sequence[str]
    page: str


def history_news(store: "Store") -> HistoryNews | None:
    """None where the run is no night of a history, or its first: there is nothing to compare it with."""
    folder = store.folder / "changes"
    if not is_file(folder / "changes.json") or not is_file(folder / PAGE):
        return None
    try:
        rows: list[dict[str, Any]] = json.loads((folder / "changes.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    worse, better = ([row for row in rows if row.get("sense") == sense] for sense in ("worse", "better"))
    sentences = [str(row.get("sentence", "")) for row in (*worse, *better)][:SHOWN]
    return HistoryNews(len(worse), len(better), sentences, f"../changes/{PAGE}")
