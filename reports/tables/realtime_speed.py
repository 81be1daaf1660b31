"""How fast an engine is where it errs by a per cent or less: single trials that anybody can run again, as times real time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from plumbline.harness.findings.cost_point import Point
from plumbline.harness.findings.prices import PER_SECOND
from plumbline.harness.store.store import Store
from plumbline.reports.tables.priced_scenes import scenes
from plumbline.reports.words.catalogue import cases, engines, titled
from plumbline.reports.words.text import TIMES, amount

WITHIN = 0.01
"""Of the case's scale."""


@dataclass(frozen=True, slots=True)
class Pace:
    """The cheapest clocked trial of an engine in a case that passes every check and errs by no more than `WITHIN`.

    Terms: times, low, high [1]: simulated over CPU seconds with the 95 % interval. error: share of the case's scale. short: was
    no cheaper trial of the engine run that errs more? Then a coarser one might do as well, and the pace is a lower bound of
    what a per cent allows.
    """

    case: str
    title: str
    engine: str
    track: str
    dt: float
    substeps: int
    times: float
    low: float
    high: float
    error: float
    short: bool
    unstable: bool
    trial: str

    @property
    def words(self) -> str:
        """'at least 120\N{MULTIPLICATION SIGN} real time'."""
        return f"{'at least ' if self.short else ''}{amount(self.times)}{TIMES} real time"

    @property
    def percent(self) -> str:
        """'0.8 % error'; of what is below a thousandth of a per cent no more is said."""
        return "< 0.001 % error" if self.error < 1e-5 else f"{amount(100 * self.error, 2)} % error"


@dataclass(frozen=True, slots=True)
class Paced:
    """A case with the pace of each engine that people can deploy, the fastest first, and of ours. Terms: level: how many of
    the first cannot be told apart: their intervals meet. none: engines without such a trial."""

    case: str
    title: str
    paces: Sequence[Pace]
    level: int
    none: Sequence[str]
    ours: Sequence[Pace]


def _cheapest(points: Sequence[Point], title: str) -> Pace | None:
    """Args: points: of one engine in one scene."""
    clocked = [point for point in points if point.clocked]
    within = [point for point in clocked if point.error <= WITHIN and point.status == "passed"]
    if not within:
        return None
    point = min(within, key=lambda point: point.cost)
    return Pace(
        case=point.case,
        title=title,
        engine=point.engine,
        track=point.track,
        dt=point.dt,
        substeps=point.substeps,
        times=1 / point.cost,
        low=1 / (point.high or point.cost),
        high=1 / (point.low or point.cost),
        error=point.error,
        short=not any(other.cost < point.cost and other.error > WITHIN for other in clocked),
        unstable=point.unstable,
        trial=point.trial,
    )


def pace_of(store: Store, case: str, engine: str, track: str) -> Pace | None:
    """Of an engine on one track, in the scene of a case where it is slowest; None where it has none in one of them."""
    mine = [scene for scene in scenes(store) if scene.case == case and scene.unit == PER_SECOND]
    paces = [
        _cheapest([p for p in scene.points if p.engine == engine and p.track == track], titled(store, case, scene.where))
        for scene in mine
    ]
    known = [pace for pace in paces if pace is not None]
    return min(known, key=lambda pace: pace.times) if known and len(known) == len(paces) else None


@lru_cache(maxsize=1)
def _all(store: Store) -> tuple[Paced, ...]:
    yard = {name for name, engine in engines(store).items() if engine["ours"]}
    made = []
    for scene in scenes(store):
        if scene.unit != PER_SECOND:
            continue
        title, asked = titled(store, scene.case, scene.where), list(dict.fromkeys(point.engine for point in scene.points))
        paces = {name: _cheapest([p for p in scene.points if p.engine == name], title) for name in asked}
        known = sorted((pace for pace in paces.values() if pace is not None), key=lambda pace: -pace.times)
        ranked = [pace for pace in known if pace.engine not in yard]
        if ranked:
            level = sum(pace.high >= ranked[0].low for pace in ranked)
            none = [name for name, pace in paces.items() if pace is None and name not in yard]
            made.append(Paced(scene.case, title, ranked, level, none, [pace for pace in known if pace.engine in yard]))
    return tuple(made)


def three(store: Store) -> list[Paced]:
    """The case in which the fastest engine is slowest, the one in the middle and the one in which it is fastest.

    Of each family only the case that most engines have a pace in stands for it, of several the slowest: three cases of one kind
    would say one thing.
    """
    most: dict[str, Paced] = {}
    for paced in _all(store):
        family = str(cases(store)[paced.case]["family"])
        if family not in most or _rank(paced) > _rank(most[family]):
            most[family] = paced
    order = sorted(most.values(), key=lambda paced: paced.paces[0].times)
    chosen = sorted({0, math.floor((len(order) - 1) / 2), len(order) - 1}) if order else []
    return [order[index] for index in chosen]


def _rank(paced: Paced) -> tuple[int, float]:
    return len(paced.paces), -paced.paces[0].times
