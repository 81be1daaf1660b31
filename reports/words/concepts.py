"""The concepts of a first course, chapter by chapter, with their engine file and their case: read from `docs/book.md` alone."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import cases

PLACES = (Path(__file__).parents[1] / "book.md", Path(__file__).resolve().parents[2] / "docs" / "book.md")
"""Where the page lies in an installed package, and in a working copy."""
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
    made = []
    for block in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        title, _, text = block.partition("\n")
        lines = [line.strip() for line in text.splitlines() if line.startswith("|")]
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]  # below a header and its rule
        if rows:
            anchor = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
            made.append(Chapter(title=title.strip(), anchor=anchor, concepts=tuple(_concept(row) for row in rows)))
    return tuple(made)


@cache
def book() -> tuple[Chapter, ...]:
    """The chapters of `docs/book.md`; none where this installation lacks it."""
    path = next((path for path in PLACES if path.is_file()), None)
    return () if path is None else chapters(path.read_text(encoding="utf-8"))


def indexed(store: Store) -> bool:
    """Has the run a case that measures a concept?"""
    measured = {concept.case for chapter in book() for concept in chapter.concepts}
    return not measured.isdisjoint(cases(store))
