"""Who leads: the one rule by which every table, page and sentence says which engine is farthest, cheapest or most accurate; and
who does at equal sub-steps and at equal time, with the reference engine and without it.

What an engine comes to is an interval, the more the better: a limit lies between what held and what broke, a cost in its error
bar, an error within a per cent of itself. An engine leads where no other's interval lies wholly beyond its own; engines whose
intervals meet lead together, for their order is not known.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.limits_found import CONSTANT, Hold, Search
from plumbline.harness.findings.prices import Price
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped
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


def cheapness(cost: Interval, *, bound: bool) -> Extent:
    """Of a cost with its interval, where that is known. Args: bound: may it be less, by no one knows how much?"""
    least, most = (end if end == end else cost.value for end in cost.ends)
    return -math.log(most), math.inf if bound else -math.log(least)


def exactness(error: float, more_is_better: bool = False) -> Extent:
    """Of an error, or of a headline that is the better the more it is; what is within `ALIKE` of another equals it."""
    return (error / ALIKE, error) if more_is_better else (-math.log(ALIKE * error), -math.log(error))


BUDGETS = (1e-4, 1e-3)
"""CPU seconds for one time step of a case that engines are compared at: a tenth of a millisecond, and a millisecond."""
PAIR = attrgetter("case", "where", "target")
"""Of a price: the pair of case and error that it is of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """How far one engine goes along one axis under one condition.

    Terms:
        search: it is read off. at: 'equal sub-step' or 'equal time'. condition: what is equal, a sub-step or a CPU time for one
        time step of the case [s]. hold: the hardest value that held, None where none did. leads, leads_without: alone or with
        others, among all engines and without the reference engine.
    """

    search: Search
    at: str
    condition: float
    hold: Hold | None
    leads: bool = False
    leads_without: bool = False

    @property
    def parts(self) -> int:
        """That time steps were to be taken in, 0 where that was open."""
        return self.search.parts if self.at == "equal sub-step" else 0

    @property
    def reach(self) -> float:
        """The place of what held between easy (0) and extreme (1)."""
        return 0.0 if self.hold is None else self.hold.reach

    @property
    def further(self) -> float:
        """That of the next harder value, tried or too dear."""
        return 0.0 if self.hold is None else self.hold.further


@dataclass(frozen=True, slots=True, kw_only=True)
class Lead:
    """How often an engine leads. Terms: what: 'axes' or 'pairs' of case and error; at, condition: what was equal, 0 where that
    differs from pair to pair. ours: was the reference engine among them? alone, shared: how often; of: how many there were."""

    what: str
    at: str
    condition: str
    ours: bool
    engine: str
    alone: int
    shared: int
    of: int


def reaches(searches: Iterable[Search]) -> list[Reach]:
    """Every axis under every condition, engine by engine; axes that were not searched at equal sub-steps have times alone."""
    answered = (s for s in searches if not s.remedied and s.verdict not in ("unsupported", "unavailable", CONSTANT))
    reached: list[Reach] = []
    for group in grouped(answered, attrgetter("searched_along")).values():
        for parts in sorted({search.parts for search in group if search.parts}):
            level = [search for search in group if search.parts == parts and search.fair]
            reached += _led([_last(search, "equal sub-step", search.dt / parts, search.holds) for search in level])
        for budget in BUDGETS:
            reached += _led(
                [_within([search for search in group if search.engine == name], budget) for name in _engines(group)]
            )
    return reached


def _engines(group: Sequence[Search | Price]) -> list[str]:
    return list(dict.fromkeys(row.engine for row in group))


def _within(mine: Sequence[Search], budget: float) -> Reach:
    """The farthest of an engine's searches among what it held at a cost within the budget; nothing is interpolated."""
    made = []
    for search in mine:
        cheap = [hold for hold in search.holds if hold.cost is not None and hold.cost <= budget]
        made.append(_last(search, "equal time", budget, cheap))
    return max(made, key=lambda reach: (reach.hold is not None, reach.reach, -((reach.hold and reach.hold.cost) or 0.0)))


def _last(search: Search, at: str, condition: float, holds: Sequence[Hold]) -> Reach:
    return Reach(search=search, at=at, condition=condition, hold=holds[-1] if holds else None)


def _question(axis: Sequence[Reach]) -> LeadQuestion:
    extents = {reach.search.engine: (reach.reach, reach.further) for reach in axis if reach.hold is not None}
    return LeadQuestion(extents, [reach.search.engine for reach in axis])


def _led(axis: Sequence[Reach]) -> list[Reach]:
    question = _question(axis)
    first, others = leaders(question.extents), leaders(question.to_deploy.extents)
    return [replace(reach, leads=reach.search.engine in first, leads_without=reach.search.engine in others) for reach in axis]


def axis_leads(reached: Sequence[Reach]) -> list[Lead]:
    """How often each engine leads on axes: at each share of the case's time step, and at each budget of time."""

    def condition_of(reach: Reach) -> tuple[str, str]:
        if reach.parts:
            return reach.at, "dt" + (f"/{reach.parts}" if reach.parts > 1 else "")
        return reach.at, f"{1e3 * reach.condition:g} ms a step"

    leads = []
    order = sorted(reached, key=lambda reach: (reach.at, reach.parts, reach.condition if not reach.parts else 0.0))
    for (at, condition), level in grouped(order, condition_of).items():
        questions = [_question(axis) for axis in grouped(level, attrgetter("search.searched_along")).values()]
        leads += _leads("axes", at, condition, True, questions)
        leads += _leads("axes", at, condition, False, [question.to_deploy for question in questions])
    return leads


def pair_leads(prices: Sequence[Price], points: Sequence[CostPoint]) -> list[Lead]:
    """How often each engine leads in pairs of case and error that anybody reaches.

    At equal time that is the cheapest, within the intervals of costs, of which an upper bound has no lower end; at equal
    sub-step the one that comes down to the error in the coarsest steps that were run.
    """
    by_scene, pairs = grouped(points, attrgetter("case", "where")), grouped(prices, PAIR)
    coarsest = [
        LeadQuestion(_coarsest(by_scene.get((case, where), ()), target, _engines(offers)), _engines(offers))
        for (case, where, target), offers in pairs.items()
    ]
    leads = []
    for at, questions in (("equal sub-step", coarsest), ("equal time", [*map(_cheapest, pairs.values())])):
        for ours in (True, False):
            put = questions if ours else [question.to_deploy for question in questions]
            leads += _leads("pairs", at, "", ours, [question for question in put if question.extents])
    return leads


def cheapest(prices: Sequence[Price]) -> list[LeadQuestion]:
    """Which engine to deploy is cheapest? Of each pair of case and error that one of them reaches."""
    questions = [_cheapest(offers).to_deploy for offers in grouped(prices, PAIR).values()]
    return [question for question in questions if question.extents]


def _cheapest(offers: Sequence[Price]) -> LeadQuestion:
    """Of one pair; an upper bound says nothing of how little a cost may be."""
    costs = {
        price.engine: cheapness(price.reached.cost, bound=price.verdict == "at most")
        for price in offers
        if price.reached is not None
    }
    return LeadQuestion(costs, _engines(offers))


def _coarsest(points: Iterable[CostPoint], target: float, engines: Sequence[str]) -> dict[str, Extent]:
    extents: dict[str, Extent] = {}
    for point in points:
        if point.engine in engines and point.error <= target:
            step = max(point.substep, extents.get(point.engine, (0.0, 0.0))[0])
            extents[point.engine] = (step, step)
    return extents


def _leads(what: str, at: str, condition: str, ours: bool, questions: Sequence[LeadQuestion]) -> list[Lead]:
    return [Lead(what=what, at=at, condition=condition, ours=ours, **each._asdict()) for each in standing(questions)]
