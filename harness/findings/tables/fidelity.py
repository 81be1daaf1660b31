"""Robots that were read from files: what each of their elements became in the scene, and what that may change."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.scene.importers import fidelity
from plumbline.harness.store.imported_scenes import fidelity_of
from plumbline.harness.store.store import Store

COLUMNS = ("robot", *fidelity.COLUMNS)
BRIEF = ("robot", *fidelity.BRIEF)


def rows(store: Store) -> list[dict[str, Any]]:
    """One row for each element, or all elements of a kind that share a fate."""
    return fidelity_of(store.folder)


def brief(row: Mapping[str, Any]) -> Sequence[object]:
    """What a terminal has room for."""
    return [row["robot"], *fidelity.brief(dict(row))]


def sentences(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """How many of each outcome."""
    if not table:
        return ["no robot of this folder was read from a file of another format"]
    counts = {word: sum(row["outcome"] == word for row in table) for word in ("exact", "approximated", "left_out")}
    return [", ".join(f"{count} rows {word.replace('_', ' ')}" for word, count in counts.items())]
