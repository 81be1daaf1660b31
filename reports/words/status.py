"""How each outcome of a trial is shown: a symbol, a word and a colour, never a colour alone."""

from collections.abc import Iterable
from dataclasses import dataclass

from plumbline.reports.words.called import WORDS


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusWord:
    """An outcome as a reader meets it.

    Terms:
        name: as in the table `trials`. symbol: one character that differs in shape from all others. answered: is there a
        trajectory that a metric could judge? meaning: for the legend. rank: the higher, the worse.
    """

    name: str
    symbol: str
    meaning: str
    rank: int
    answered: bool = False

    @property
    def style(self) -> str:
        """The name as a class of the style sheet."""
        return self.name.replace(" ", "-")


STATUSES, VERDICTS, _OTHERS = (
    {name: StatusWord(name=name, **about) for name, about in WORDS[table].items()}
    for table in ("statuses", "verdicts", "others")
)
"""Outcomes of trials, and verdicts on engines in a scene without a truth."""
FINITE, UNKNOWN, NOT_RUN = _OTHERS.values()
"""What 'passed' means in a scene of one's own, whose trials are asked nothing else; a status of a newer store; of a robot."""


def outcome(name: str) -> StatusWord:
    """The outcome of that name; a name from a newer store is shown as unknown, not hidden."""
    return STATUSES.get(name, UNKNOWN)


def worst(names: Iterable[str]) -> StatusWord:
    """The one that a reader must not miss."""
    return max((outcome(name) for name in names), key=lambda candidate: candidate.rank)
