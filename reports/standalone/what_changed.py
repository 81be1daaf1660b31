"""The page What changed: two run folders side by side, in sentences by weight, and as one table."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

from plumbline.harness.findings.changes import Change, Changes
from plumbline.harness.findings.changes.words import command, folded, headline, judged_in_short, one_a_side, sentence, titled
from plumbline.harness.store.disk import write_atomically
from plumbline.reports.html.policy import guarded
from plumbline.reports.html.style import copy_style
from plumbline.reports.html.template import environment

PAGE = "what-changed.html"
_SECTIONS = (
    ("worse", "Worse", "Worse", ("worse",)),
    ("unconfirmed", "Unconfirmed", "Unconfirmed", ("unconfirmed",)),
    ("better", "Better", "Better", ("better",)),
    ("alike", "Other bits, as good", "Alike", ("within tolerance",)),
    ("facts", "What else changed", "Also", ("neither",)),
)
_NOTES = {
    "worse": "Verdicts, determinism, limits, errors and prices beyond what chance and the truths allow; each with the command "
    "that shows it again.",
    "unconfirmed": "Prices that are higher beyond their own interval, by timings too unstable to judge by; each with the "
    "command that measures it again.",
    "better": "Verdicts, determinism, limits, errors and prices that are better by more than chance and the truths allow.",
    "alike": "The answer is another to the last bit; its error moved by less than a hundredth of its bound, than the truth may "
    "be off, or than a last bit moves it.",
    "facts": "Versions, settings, sources, the machine, warnings, and which trials there are.",
}
_STYLE = {
    "worse": "failed",
    "better": "passed",
    "within tolerance": "interrupted",
    "neither": "unavailable",
    "unconfirmed": "interrupted",
}
_MOST_SENTENCES, _MOST_ROWS, _OPEN = 200, 2000, 24
"""On a page that a phone can hold; changes.json beside it has all. So many sentences stand open, the next fold."""


def what_changed_page(changes: Changes, gated: Collection[str] = ()) -> str:
    """The page as text, with its policy."""
    sections = [_section(name, title, changes, senses) | {"short": short} for name, title, short, senses in _SECTIONS]
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
                (row, _STYLE[row.sense], sentence(row))
                for row in (titled(change, changes.titles) for change in changes.rows[:_MOST_ROWS])
            ],
        )
    )
    return guarded(page)


def _section(name: str, title: str, changes: Changes, senses: Collection[str]) -> dict[str, Any]:
    rows: list[Change] = [row for row in changes.rows if row.sense in senses]
    groups = one_a_side(folded(rows, changes.titles))
    shown = [(text, command(group[0], changes)) for text, group in groups[:_MOST_SENTENCES]]
    return {
        "name": name,
        "title": title,
        "note": _NOTES[name],
        "all": len(rows),
        "shown": shown,
        "more": len(groups) - len(shown),
    }


def write_what_changed(changes: Changes, folder: Path, gated: Collection[str] = ()) -> Path:
    """Write the page and its style into a folder; it needs no network and no run folder. Returns: its path."""
    copy_style(folder)
    write_atomically(folder / PAGE, what_changed_page(changes, gated).encode("utf-8", "backslashreplace"))
    return folder / PAGE
