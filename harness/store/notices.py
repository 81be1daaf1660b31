"""A notice as a record keeps it: what an engine, its adapter or the harness had to say of a trial."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class StoredNotice:
    """A notice in plain values.

    Terms: as of `harness.adapter.Notice`; effect: the name of it, '' for a note. by: who says it: the engine or its adapter,
    what judges the answer, what clocks it roughly beside its run, or its timing run.
    """

    text: str
    kind: Literal["note", "surplus", "missing", "capacity"] = "note"
    effect: str = ""
    by: Literal["engine", "judge", "rough clock", "timing"] = "engine"

    def __str__(self) -> str:
        """As a line for people, by its kind first."""
        return self.text if self.kind == "note" else f"{self.kind}: {self.text}"


def short_of(notices: Iterable[StoredNotice]) -> str:
    """What an engine could not hold, before the rest of a reason: 'contacts reached 1000, ...; '; '' if it held all."""
    return "".join(f"{notice.text}; " for notice in notices if notice.kind == "capacity")


def notice_of(line: str) -> StoredNotice:
    """The notice of a line for people, which names its effect as code or people do."""
    from plumbline.harness.scene import Effect  # late: who has a journal does not pay for scenes

    words = line.lower().replace(",", " ").replace(":", " ").replace("(", " ").split()
    effect = next((name for name in Effect(~0).names if name in words or name.replace("_", " ") in " ".join(words)), "")
    for kind in ("surplus", "missing", "capacity"):
        if line.startswith(f"{kind}: "):
            return StoredNotice(line.removeprefix(f"{kind}: "), kind, effect if kind != "capacity" else "")
    return StoredNotice(line)
