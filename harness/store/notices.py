"""A notice as a record keeps it: what an engine, its adapter or the harness had to say of a trial."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class StoredNotice:
    """A notice in plain values. Terms: as of `harness.adapter.Notice`; effect: the name of it, '' for a note."""

    text: str
    kind: Literal["note", "surplus", "missing"] = "note"
    effect: str = ""

    def __str__(self) -> str:
        """As a line for people, by its kind first."""
        return self.text if self.kind == "note" else f"{self.kind}: {self.text}"
