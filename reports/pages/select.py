"""The page that answers which engine, with weights and requirements that a reader sets."""

from collections.abc import Mapping
from functools import partial

from plumbline.harness.findings.selection import CRITERIA, listing, read_preset
from plumbline.harness.findings.selection.words import COLUMN_WORDS, dropped_sentence, headline
from plumbline.harness.store.store import Store
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page
from plumbline.reports.tables.csv import sheet
from plumbline.reports.tables.selection import (
    answer,
    answers_by_purpose,
    asked_of_several,
    evidence_by_purpose,
    live,
    notes_and_command,
    standings,
)
from plumbline.reports.words.catalogue import FAMILIES, cases, engine_title


def concerns(store: Store) -> bool:
    """Only where several engines of others were asked."""
    return asked_of_several(store)


def render(store: Store) -> Mapping[str, str]:
    """The page."""
    found, known, titled = answer(store), cases(store), partial(engine_title, store)

    def called(name: str) -> str:
        return FAMILIES[name].lower() if name in FAMILIES else str(known[name]["title"])

    leaned_on = list(evidence_by_purpose(store))
    notes, command = notes_and_command(store, found)
    placed = [place.engine for place in found.rank.places] if found.rank is not None else []
    elsewhere = dict.fromkeys(name for each in answers_by_purpose(store).values() for name in each.evidence.engines)
    page = fill(
        "select.html",
        store,
        title="Which engine",
        standings=standings(store, found),
        others=[name for name in elsewhere if name not in placed],
        words=COLUMN_WORDS,
        purposes=[(name, read_preset(name).title) for name in answers_by_purpose(store)],
        notes=notes,
        command=command,
        headline=headline(found, titled),
        dropped=[dropped_sentence(drop, titled, called) for drop in found.dropped],
        criteria={name: meaning for name, meaning in CRITERIA.items() if any(key[0] == name for key in found.evidence.table)},
        evidence=[evidence for evidence, _ in leaned_on],
        live=live(store),
    )
    sheets = {evidence.file: sheet(listing.COLUMNS, listing.rows(chosen)) for evidence, chosen in leaned_on}
    return {"select.html": page} | sheets


PAGE = Page(name="select", title="Select", order=5, render=render, concerns=concerns)
