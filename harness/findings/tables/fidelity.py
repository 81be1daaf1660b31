"""Robots that were read from files: what each of their elements became in the scene, and what that may change."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.columns import Column, Table
from plumbline.harness.scene.importers import fidelity
from plumbline.harness.store.imported_scenes import fidelity_of


def of_element(row: Mapping[str, Any]) -> list[object]:
    """What becomes of an element, under `fidelity.BRIEF`."""
    return fidelity.brief(dict(row))


def _column(position: int, heading: str) -> Column:
    return Column(heading, lambda row: of_element(row)[position])


def _sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """How many of each outcome."""
    if not rows:
        return ["no robot of this folder was read from a file of another format"]
    counts = {word: sum(row["outcome"] == word for row in rows) for word in ("exact", "approximated", "left_out")}
    return [", ".join(f"{count} rows {word.replace('_', ' ')}" for word, count in counts.items())]


TABLE = Table(
    holds=" ".join(("robot", *fidelity.COLUMNS)),
    objects=lambda store: fidelity_of(store.folder),
    shown=(Column("robot", "robot"), *(_column(position, heading) for position, heading in enumerate(fidelity.BRIEF))),
    sentences=_sentences,
)
