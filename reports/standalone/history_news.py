"""What a night of a history says of what changed since each answer was last seen, from the files beside its report."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.words import sentence, titled
from plumbline.harness.store.store import Store
from plumbline.reports.standalone.what_changed import PAGE
from plumbline.reports.tables.trial_results import is_file
from plumbline.reports.words.catalogue import titles

SHOWN = 4


@dataclass(frozen=True, slots=True)
class HistoryNews:
    """Terms: worse, better: how many changes; sentences: of the worse ones first, heaviest first; page: its address."""

    worse: int
    better: int
    sentences: Sequence[str]
    page: str


def _sentence(row: Mapping[str, Any], names: Mapping[str, str]) -> str:
    """With titles; as the file has it where its row is of another version."""
    try:
        return sentence(titled(Change(**{field.name: row[field.name] for field in fields(Change)}), names))
    except (KeyError, TypeError, ValueError):
        return str(row.get("sentence", ""))


def history_news(store: Store) -> HistoryNews | None:
    """None where the run is no night of a history, or its first: there is nothing to compare it with."""
    folder = store.folder / "changes"
    if not is_file(folder / "changes.json") or not is_file(folder / PAGE):
        return None
    try:
        rows: list[dict[str, Any]] = json.loads((folder / "changes.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    worse, better = ([row for row in rows if row.get("sense") == sense] for sense in ("worse", "better"))
    names = titles(store)
    sentences = [_sentence(row, names) for row in (*worse, *better)[:SHOWN]]
    return HistoryNews(len(worse), len(better), sentences, f"../changes/{PAGE}")
