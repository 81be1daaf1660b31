"""How each outcome of a trial is shown: a symbol, a word and a colour, never a colour alone."""

from collections.abc import Iterable
from dataclasses import dataclass


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


STATUSES: dict[str, StatusWord] = {
    status.name: status
    for status in (
        StatusWord(name="passed", symbol="✓", meaning="every check of the case holds", rank=0, answered=True),
        StatusWord(name="failed", symbol="✕", meaning="at least one check does not hold", rank=4, answered=True),
        StatusWord(
            name="diverged",
            symbol="∞",
            meaning="NaN, infinity, a joint that stays open, or a state that the engine reset in silence",
            rank=5,
        ),
        StatusWord(
            name="unsupported", symbol="∅", meaning="the engine cannot express the scene; nothing is approximated", rank=1
        ),
        StatusWord(name="unavailable", symbol="○", meaning="this machine cannot run it as asked; the reason says why", rank=2),
        StatusWord(name="timeout", symbol="◷", meaning="stopped at its deadline", rank=6),
        StatusWord(name="crashed", symbol="‡", meaning="the process ended by a signal or an unexpected error", rank=8),
        StatusWord(name="oom", symbol="▣", meaning="stopped at its memory limit", rank=7),
        StatusWord(name="interrupted", symbol="‖", meaning="the run was stopped by the person who started it", rank=3),
    )
}
"""In the order of `harness.store.record.Status`."""

FINITE = StatusWord(
    name="finite",
    symbol="·",
    meaning="every number is finite; whether they are right, engines have to agree on",
    rank=0,
    answered=True,
)
"""What 'passed' means in a scene of one's own, whose trials are asked nothing else."""

VERDICTS: dict[str, StatusWord] = {
    verdict.name: verdict
    for verdict in (
        StatusWord(
            name="agrees", symbol="✓", meaning="ends, as its step goes to zero, where two engines or more agree", rank=0
        ),
        StatusWord(name="converges", symbol="→", meaning="draws together as its step goes to zero; no limit is agreed", rank=3),
        StatusWord(
            name="converges elsewhere", symbol="≠", meaning="draws together, but not at the limit that is agreed", rank=4
        ),
        StatusWord(name="does not converge", symbol="∿", meaning="ends elsewhere at each time step", rank=6),
        StatusWord(
            name="diverged", symbol="∞", meaning="left the numbers, or its joints, at its finest step or at all but two", rank=5
        ),
        StatusWord(name="cannot", symbol="∅", meaning="has no answer at three steps; the reason says why", rank=1),
    )
}
"""The words for engines in a scene without a truth, as `harness.findings.agreement` has them."""

UNKNOWN = StatusWord(name="unknown", symbol="?", meaning="a status that this version does not know", rank=9)


def outcome(name: str) -> StatusWord:
    """The outcome of that name; a name from a newer store is shown as unknown, not hidden."""
    return STATUSES.get(name, UNKNOWN)


def worst(names: Iterable[str]) -> StatusWord:
    """The one that a reader must not miss."""
    return max((outcome(name) for name in names), key=lambda candidate: candidate.rank)
