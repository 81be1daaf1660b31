"""A notice: what an engine or its adapter has to say of a simulation."""

from dataclasses import dataclass
from typing import Literal

from plumbline.harness.scene import Effect


@dataclass(frozen=True, slots=True)
class Notice:
    """One thing that a user of an answer should know.

    Terms:
        text: without its full stop. kind: 'surplus', where an effect is computed that the scene leaves out, and cannot be
        switched off; 'missing', where one is not that the scene calls for; 'capacity', where the engine could not hold all that
        the scene has, so that what it answers is about less; else 'note'. effect: which one, None for a note or a capacity.
    """

    text: str
    kind: Literal["note", "surplus", "missing", "capacity"] = "note"
    effect: Effect | None = None

    def __str__(self) -> str:
        """As a line for people, by its kind first."""
        return self.text if self.kind == "note" else f"{self.kind}: {self.text}"


def as_notices(warnings: tuple[str | Notice, ...]) -> tuple[Notice, ...]:
    """What `Simulation.warnings` says; a plain text is a note, whatever it reads."""
    return tuple(Notice(warning) if isinstance(warning, str) else warning for warning in warnings)
