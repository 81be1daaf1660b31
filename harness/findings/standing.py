"""Who leads: the one rule by which every table, page and sentence says which engine is farthest, cheapest or most accurate.

What an engine comes to is an interval, the more the better: a limit lies between what held and what broke, a cost in its error
bar, an error within a per cent of itself. An engine leads where no other's interval lies wholly beyond its own; engines whose
intervals meet lead together, for their order is not known.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from plumbline.harness.study.engine_versions import engine_of

REFERENCE = "reference"
"""The engine that leads are counted with and without."""
EQUAL = 1e-9
ALIKE = 1.01
"""Errors within one part in a hundred of each other are equal: such an order would change with the compiler."""

Extent = tuple[float, float]
"""How far an engine certainly comes and may come, the more the better: (0.4, 0.5) of an axis; (-log 3, -log 2) of a cost."""


class LeadQuestion(NamedTuple):
    """Which engine goes farthest in one thing? extents: of the engines with an answer. asked: all that it was put to."""

    extents: Mapping[str, Extent]
    asked: Sequence[str]

    @property
    def to_deploy(self) -> "LeadQuestion":
        """The same without the reference engine."""
        extents = {name: extent for name, extent in self.extents.items() if not is_reference(name)}
        return LeadQuestion(extents, [name for name in self.asked if not is_reference(name)])


class Standing(NamedTuple):
    """How often an engine leads. alone, shared: by itself and with others. of: how many questions were put to it."""

    engine: str
    alone: int
    shared: int
    of: int


def is_reference(engine: str) -> bool:
    """Is it the reference engine, of whatever version?"""
    return engine_of(engine) == REFERENCE


def leaders(extents: Mapping[str, Extent]) -> frozenset[str]:
    """The engines whose interval overlaps the best lower bound; empty if there are no engines."""
    best = max((low for low, _ in extents.values()), default=-math.inf)
    return frozenset(name for name, (low, high) in extents.items() if high > best + EQUAL or low >= best - EQUAL)


def standing(questions: Sequence[LeadQuestion]) -> list[Standing]:
    """How often each engine leads, by name."""
    first = [leaders(question.extents) for question in questions]
    return [
        Standing(
            name,
            alone=sum(names == {name} for names in first),
            shared=sum(name in names and len(names) > 1 for names in first),
            of=sum(name in question.asked for question in questions),
        )
        for name in sorted({name for question in questions for name in question.asked})
    ]


def counted(standings: Iterable[Standing]) -> list[tuple[str, int]]:
    """Engines and how often each leads alone, most first."""
    return sorted(((each.engine, each.alone) for each in standings), key=lambda pair: -pair[1])


def cheapness(cost: float, low: float | None, high: float | None, *, bound: bool) -> Extent:
    """Of a cost with its interval, where that is known. Args: bound: may it be less, by no one knows how much?"""
    least, most = (end if end is not None and end == end else cost for end in (low, high))
    return -math.log(most), math.inf if bound else -math.log(least)


def exactness(error: float, more_is_better: bool = False) -> Extent:
    """Of an error, or of a headline that is the better the more it is; what is within `ALIKE` of another equals it."""
    return (error / ALIKE, error) if more_is_better else (-math.log(ALIKE * error), -math.log(error))
