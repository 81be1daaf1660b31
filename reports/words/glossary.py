"""The words of the project with their meanings: read from `docs/glossary.md` alone.

The concepts of a first course, chapter by chapter, with their engine file and their case: read from `docs/book.md` alone.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from plumbline.harness.store.store import Store
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import cases

PLACES = (Path(__file__).parents[1], Path(__file__).resolve().parents[2] / "docs")
"""Where pages lie in an installed package, and in a working copy."""


def _page(name: str) -> str:
    """A page of the documentation; nothing if this installation lacks it."""
    path = next((folder / name for folder in PLACES if (folder / name).is_file()), None)
    return "" if path is None else path.read_text(encoding="utf-8")


def _tables(page: str) -> Iterator[tuple[str, list[str]]]:
    """Each heading of the second level, with the rows of the table below it."""
    for block in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        title, _, text = block.partition("\n")
        yield title.strip(), [line.strip().strip("|") for line in text.splitlines() if line.startswith("|")][2:]  # below a rule


def _anchor(title: str) -> str:
    """A title as part of an address."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


@dataclass(frozen=True, slots=True, kw_only=True)
class GlossaryEntry:
    """A row. words: that mean the same or belong together; meaning: in sentences, with code between backticks. anchor: in an
    address."""

    section: str
    words: tuple[str, ...]
    meaning: str

    @property
    def anchor(self) -> str:
        """The first word as part of an address."""
        return _anchor(self.words[0])


def entries(page: str) -> tuple[GlossaryEntry, ...]:
    """The rows of a page in Markdown: headings of the second level, each with a table of two columns."""
    read: list[GlossaryEntry] = []
    for title, rows in _tables(page):
        for row in rows:
            words, meaning = (cell.strip() for cell in row.split("|", 1))
            read.append(GlossaryEntry(section=title, words=tuple(words.split(", ")), meaning=meaning))
    return tuple(read)


@cache
def glossary() -> tuple[GlossaryEntry, ...]:
    """The entries of `docs/glossary.md`; none if this installation lacks it."""
    return entries(_page("glossary.md"))


HOUSE_WORDS: dict[str, str] = WORDS["house"]
"""Entries whose word means something of its own here, and their forms: each page links the first of each to its entry."""
WORD = re.compile(r"(?<![\w-])(?:" + "|".join(f"({form})" for form in HOUSE_WORDS.values()) + r")(?![\w-])", re.IGNORECASE)


def house_word(met: re.Match[str]) -> str:
    """Which one a match of `WORD` is, counted from the end of its groups, so that other groups may come before."""
    return [*HOUSE_WORDS][next(k for k, form in enumerate(met.groups()[-len(HOUSE_WORDS) :]) if form)]


_MARKDOWN = re.compile(
    r"^```.*?^```|^#.*?$|^\|.*?$|`[^`]*`|\[(?P<linked>[^\]]*)\]\([^)]*glossary\.md#[^)]*\)"
    r"|!?\[(?:[^\]\[]|\[[^\]]*\]\([^)]*\))*\]\([^)]*\)|https?://\S+|" + WORD.pattern,
    re.MULTILINE | re.DOTALL | re.IGNORECASE,
)
"""What a page in Markdown has of code, headings, tables and links, and of words in its prose."""


def linked(page: str, address: str) -> str:
    """A page in Markdown whose first of each house word leads to its section. Args: address: of the glossary, from the page."""
    sections = {word: re.sub(r"[^a-z]+", "-", entry.section.lower()) for entry in glossary() for word in entry.words}
    seen = set[str]()

    def link(met: re.Match[str]) -> str:
        shown = WORD.fullmatch(met["linked"]) if met["linked"] else None
        if shown is None and not any(met.groups()[-len(HOUSE_WORDS) :]):
            return met[0]
        word, plain = house_word(shown or met), met["linked"] or met[0]
        text = plain if word in seen else f"[{plain}]({address}#{sections[word]})"
        seen.add(word)
        return text

    return _MARKDOWN.sub(link, page)


_CASE = re.compile(r"`(?P<case>\w+)`(?: with `(?P<setting>\w+ = [^`]+)`)?")
_FILE = re.compile(r"\[(?P<file>[^\]]+)\]\([^)]*\)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Concept:
    """One row. file: that implements it, from the root of the project. case: that measures it, '' for none. setting: of our
    engine, or parameter of the case, behind it. without: why no case measures it, commands between backticks."""

    name: str
    formula: str
    file: str
    case: str = ""
    setting: str = ""
    without: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chapter:
    """A chapter with its concepts. anchor: its name in an address."""

    title: str
    anchor: str
    concepts: tuple[Concept, ...]


def _concept(cells: list[str]) -> Concept:
    name, formula, file, measured = cells
    linked, case = _FILE.fullmatch(file), _CASE.fullmatch(measured)
    return Concept(
        name=name,
        formula=formula.strip("`"),
        file=linked["file"] if linked else file,
        case=case["case"] if case else "",
        setting=(case["setting"] or "") if case else "",
        without="" if case else measured.removeprefix("none: "),
    )


def chapters(page: str) -> tuple[Chapter, ...]:
    """The chapters of a page in Markdown: a heading of the second level with a table of four columns each."""
    return tuple(
        Chapter(title=title, anchor=_anchor(title), concepts=tuple(_concept([*map(str.strip, row.split("|"))]) for row in rows))
        for title, rows in _tables(page)
        if rows
    )


@cache
def book() -> tuple[Chapter, ...]:
    """The chapters of `docs/book.md`; none where this installation lacks it."""
    return chapters(_page("book.md"))


def indexed(store: Store) -> bool:
    """Has the run a case that measures a concept?"""
    measured = {concept.case for chapter in book() for concept in chapter.concepts}
    return not measured.isdisjoint(cases(store))
