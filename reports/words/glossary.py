"""The words of the project with their meanings: read from `docs/glossary.md` alone."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PLACES = (Path(__file__).parents[1] / "glossary.md", Path(__file__).resolve().parents[2] / "docs" / "glossary.md")
"""Where the page lies in an installed package, and in a working copy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A row. words: that mean the same or belong together; meaning: in sentences, with code between backticks. anchor: in an
    address."""

    section: str
    words: tuple[str, ...]
    meaning: str

    @property
    def anchor(self) -> str:
        """The first word as part of an address."""
        return re.sub(r"[^a-z0-9]+", "-", self.words[0].lower()).strip("-")


def entries(page: str) -> tuple[Entry, ...]:
    """The rows of a page in Markdown: headings of the second level, each with a table of two columns."""
    read: list[Entry] = []
    for block in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        title, _, text = block.partition("\n")
        for line in [line for line in text.splitlines() if line.startswith("|")][2:]:  # below a header and its rule
            words, meaning = (cell.strip() for cell in line.strip("|").split("|", 1))
            read.append(Entry(section=title.strip(), words=tuple(words.split(", ")), meaning=meaning))
    return tuple(read)


@cache
def glossary() -> tuple[Entry, ...]:
    """The entries of `docs/glossary.md`; none if this installation lacks it."""
    path = next((path for path in PLACES if path.is_file()), None)
    return () if path is None else entries(path.read_text(encoding="utf-8"))
