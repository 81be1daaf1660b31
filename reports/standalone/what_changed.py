"""The page What changed: two run folders side by side, in sentences by weight, and as one table.

What a night of a history says of what changed since each answer was last seen, from the files beside its report.
"""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from plumbline.harness.findings.changes import Change, Changes
from plumbline.harness.findings.changes.words import command, folded, headline, judged_in_short, one_a_side, sentence, titled
from plumbline.harness.store.disk import write_atomically
from plumbline.harness.store.store import Store
from plumbline.reports.html.policy import copy_style, guarded
from plumbline.reports.html.template import environment
from plumbline.reports.tables.trial_results import is_file
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import titles

PAGE = "what-changed.html"
_SECTIONS = WORDS["sections"]
"""What there is to say, by sense, in the order of the page."""
_MOST_SENTENCES, _MOST_ROWS, _OPEN = 200, 2000, 24
"""On a page that a phone can hold; changes.json beside it has all. So many sentences stand open, the next fold."""


def what_changed_page(changes: Changes, gated: Collection[str] = ()) -> str:
    """The page as text, with its policy."""
    sections = [{"name": sense} | about | _section(changes, sense) for sense, about in _SECTIONS.items()]
    page = (
        environment()
        .get_template("what_changed.html")
        .render(
            headline=headline(changes),
            changes=changes,
            gated=[changes.titles.get(name, name) for name in sorted(gated)],
            barred=len(changes.regressions(gated)),
            judged=judged_in_short(changes.judged_of(gated)),
            open=_OPEN,
            sections=[section for section in sections if section["all"]],
            rows=[
                (row, _SECTIONS[row.sense]["style"], sentence(row))
                for row in (titled(change, changes.titles) for change in changes.rows[:_MOST_ROWS])
            ],
        )
    )
    return guarded(page)


def _section(changes: Changes, sense: str) -> dict[str, Any]:
    rows: list[Change] = [row for row in changes.rows if row.sense == sense]
    groups = one_a_side(folded(rows, changes.titles))
    shown = [(text, command(group[0], changes)) for text, group in groups[:_MOST_SENTENCES]]
    return {"all": len(rows), "shown": shown, "more": len(groups) - len(shown)}


def write_what_changed(changes: Changes, folder: Path, gated: Collection[str] = ()) -> Path:
    """Write the page and its style into a folder; it needs no network and no run folder. Returns: its path."""
    copy_style(folder)
    write_atomically(folder / PAGE, what_changed_page(changes, gated).encode("utf-8", "backslashreplace"))
    return folder / PAGE


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
