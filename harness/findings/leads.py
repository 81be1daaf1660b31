"""Who leads at equal sub-steps and at equal time, with the reference engine and without it, by the rule of `standing`."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.limits_found import CONSTANT, Hold, Search
from plumbline.harness.findings.prices import Price
from plumbline.harness.findings.standing import Extent, LeadQuestion, cheapness, leaders, standing
from plumbline.harness.store.rows import grouped

BUDGETS = (1e-4, 1e-3)
"""CPU seconds for one time step of a case that engines are compared at: a tenth of a millisecond, and a millisecond."""
PAIR = attrgetter("case", "where", "target")
"""Of a price: the pair of case and error that it is of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """How far one engine goes along one axis under one condition.

    Terms:
        at: 'equal sub-step' or 'equal time'. condition: what is equal, a sub-step or a CPU time for one time step of the case
        [s]. parts: that time steps were to be taken in, 0 where that was open. held: the hardest value that held, None where
        none did; reach, further: its place between easy and extreme, and that of the next harder value, tried or too dear.
        setting, substep [s], cost [s]: what it was reached with, and what one time step of the case costs then, roughly. leads,
        leads_without: alone or with others, among all engines and without the reference engine.
    """

    experiment: str
    case: str
    where: str
    axis: str
    unit: str
    engine: str
    at: str
    condition: float
    parts: int
    held: float | None
    reach: float
    further: float
    setting: str
    substep: float | None
    cost: float | None
    leads: bool = False
    leads_without: bool = False


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
    told = (s for s in searches if not s.remedied and s.verdict not in ("unsupported", "unavailable", CONSTANT))
    reached: list[Reach] = []
    for group in grouped(told, attrgetter("searched_along")).values():
        for parts in sorted({search.parts for search in group if search.parts}):
            level = [search for search in group if search.parts == parts and search.fair]
            reached += _led([_reach(search, "equal sub-step", search.dt / parts, search.holds[-1:]) for search in level])
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
        made.append(_reach(search, "equal time", budget, cheap[-1:]))
    return max(made, key=lambda reach: (reach.held is not None, reach.reach, -(reach.cost or 0.0)))


def _reach(search: Search, at: str, condition: float, last: Sequence[Hold]) -> Reach:
    hold = last[0] if last else None
    return Reach(
        experiment=search.experiment,
        case=search.case,
        where=search.where,
        axis=search.axis,
        unit=search.unit,
        engine=search.engine,
        at=at,
        condition=condition,
        parts=search.parts if at == "equal sub-step" else 0,
        held=None if hold is None else hold.value,
        reach=0.0 if hold is None else hold.reach,
        further=0.0 if hold is None else hold.further,
        setting=search.setting,
        substep=search.substep,
        cost=None if hold is None else hold.cost,
    )


def _question(axis: Sequence[Reach]) -> LeadQuestion:
    extents = {reach.engine: (reach.reach, reach.further) for reach in axis if reach.held is not None}
    return LeadQuestion(extents, [reach.engine for reach in axis])


def _led(axis: Sequence[Reach]) -> list[Reach]:
    question = _question(axis)
    first, others = leaders(question.extents), leaders(question.to_deploy.extents)
    return [replace(reach, leads=reach.engine in first, leads_without=reach.engine in others) for reach in axis]


def axis_leads(reached: Sequence[Reach]) -> list[Lead]:
    """How often each engine leads on axes: at each share of the case's time step, and at each budget of time."""

    def condition_of(reach: Reach) -> tuple[str, str]:
        if reach.parts:
            return reach.at, "dt" + (f"/{reach.parts}" if reach.parts > 1 else "")
        return reach.at, f"{1e3 * reach.condition:g} ms a step"

    leads = []
    order = sorted(reached, key=lambda reach: (reach.at, reach.parts, reach.condition if not reach.parts else 0.0))
    for (at, condition), level in grouped(order, condition_of).items():
        questions = [_question(axis) for axis in grouped(level, attrgetter("experiment", "case", "where")).values()]
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
        price.engine: cheapness(price.cost, price.low, price.high, bound=price.verdict == "at most")
        for price in offers
        if price.cost
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
