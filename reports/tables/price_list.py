"""The price list as people read it: a row for each scene and error, a column for each engine; and the scenes in which something
was clocked that has an error.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import pandas as pd

from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.emulations import share_in_words, whose
from plumbline.harness.findings.once import once
from plumbline.harness.findings.prices import PER_SECOND, Beyond, Price, Reached, Silent, priced, unit_of
from plumbline.harness.findings.standing import cheapest, counted, standing
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import titled
from plumbline.reports.words.known_findings import disputed
from plumbline.reports.words.text import TIMES, amount, duration, knobs, power, slug, step

SHOWN = 1e-2
"""The error that the list shows at first: every scene has a line for it."""
HEATS = ((1.0, "x1"), (2.0, "x2"), (10.0, "x10"), (100.0, "x100"))
"""Times the cheapest, and the shade of a cell up to there."""


@dataclass(frozen=True, slots=True)
class PriceEntry:
    """One price: its words, its shade, and what hovering says.

    Terms: law: whose laws it is about, where the adapter makes some; disputed: what is said against it; '' without.
    """

    price: Price
    text: str
    ratio: str
    between: str
    shade: str
    hint: str
    law: str = ""
    disputed: str = ""

    @property
    def trial(self) -> str:
        """The run that it leans on, '' where there is none."""
        return "" if self.price.outcome.at is None else self.price.outcome.at.trial


@dataclass(frozen=True, slots=True)
class PriceLine:
    """What one error costs in one scene, by engine; last: does no engine get farther?"""

    case: str
    title: str
    target: str
    unit: str
    last: bool
    entries: Mapping[str, PriceEntry]


def price_list(store: Store) -> list[PriceLine]:
    """All lines, from coarse to fine; below the first error from `SHOWN` on that no engine reaches nothing is left to say."""
    by_scene: dict[tuple[str, str], dict[float, dict[str, Price]]] = {}
    for price in priced(store).prices:
        by_scene.setdefault((price.case, price.where), {}).setdefault(price.target, {})[price.engine] = price
    lines: list[PriceLine] = []
    for (case, where), targets in by_scene.items():
        title = titled(store, case, where)
        for target, prices in sorted(targets.items(), reverse=True):
            last = target <= SHOWN and all(price.verdict in ("not within the ladder", "no answer") for price in prices.values())
            unit = next(iter(prices.values())).unit
            shown = "" if unit == PER_SECOND else f"per {unit}"
            least = next((price for price in prices.values() if price.cheapest), None)
            entries = {engine: marked(store, price, least) for engine, price in prices.items()}
            lines.append(PriceLine(case, title, power(round(math.log10(target))), shown, last, entries))
            if last:
                break
    return lines


@dataclass(frozen=True, slots=True)
class Tried:
    """Of one scene, by engine: how many settings were tried, and why no more. Terms: apart: the most over the least."""

    case: str
    title: str
    engines: Mapping[str, Price]
    apart: float


def tried(store: Store) -> list[Tried]:
    """A row for each scene."""
    by_scene: dict[tuple[str, str], dict[str, Price]] = {}
    for price in priced(store).prices:
        by_scene.setdefault((price.case, price.where), {}).setdefault(price.engine, price)
    made = []
    for (case, where), engines in by_scene.items():
        counts = [price.tried for price in engines.values() if price.verdict != "no answer"]
        apart = max(counts) / max(1, min(counts)) if counts else 1.0
        made.append(Tried(case, titled(store, case, where), engines, apart))
    return made


def heat(ratio: Interval | None) -> str:
    """The shade of a price over the cheapest: the darkest is the cheapest."""
    if ratio is None:
        return "out"
    return next((shade for limit, shade in HEATS if ratio.value <= limit * (1 + 1e-12)), "far")


def entry(price: Price, beside: Price | None = None) -> PriceEntry:
    """One price in words. Args: beside: the cheapest, over which its ratio is."""
    match price.outcome:
        case Reached() as met:
            return _met(price, met, beside)
        case Beyond() as beyond:
            return _outside(price, beyond)
        case Silent(verdict=verdict, reason=reason):
            return PriceEntry(price, verdict, "", "", "out", reason)


def _met(price: Price, met: Reached, beside: Price | None) -> PriceEntry:
    paced, (cost, low, high) = price.unit == PER_SECOND, met.cost
    sign = {"at most": "≥ " if paced else "at most ", "within the truth's error": "? "}.get(price.verdict, "")
    text, between = (f"{amount(1 / cost)}{TIMES}" if paced else duration(cost)), ""
    if low and high and math.isfinite(low) and math.isfinite(high):
        between = f"{amount(1 / high)} to {amount(1 / low)}{TIMES}" if paced else f"{duration(low)} to {duration(high)}"
    hint = f"{knobs(met.at.track)}, dt {step(met.at.dt, met.at.substeps)}; {price.verdict}"
    if paced:
        hint = f"{duration(cost)} of CPU time per simulated second; {hint}"
    if not price.cheapest and met.ratio is not None:
        hint += f"; {amount(met.ratio.low)} to {amount(met.ratio.high)} times the cheapest"
    return PriceEntry(price, sign + text, _ratio(price, met, beside), between, heat(met.ratio), hint)


def _ratio(price: Price, met: Reached, beside: Price | None) -> str:
    """How many times the cheapest: a bound where one of both is an upper bound, and nothing where both are."""
    if price.cheapest or met.ratio is None:
        return ""
    short = price.verdict == "at most", beside is not None and beside.verdict == "at most"
    if all(short):
        return ""
    sign, times = "≤ " if short[0] else "≥ " if short[1] else "", met.ratio.value
    return sign + amount(times, 3 if times < 2 else 2)


def marked(store: Store, price: Price, beside: Price | None = None) -> PriceEntry:
    """One price in words, with whose laws it is about and whether it is disputed; settings have their track's laws."""
    leans_on = price.outcome.at
    law = whose(store.catalogue, price.engine, price.case, store.bases.get(leans_on.trial, "") if leans_on else "")
    own = share_in_words(price.reached.at.emulated) if price.reached is not None else ""
    against = disputed(store, price.engine, price.case)
    plain = entry(price, beside)
    hint = "; ".join(word for word in (plain.hint, f"{law} by the adapter" if law else "", own, against) if word)
    return replace(plain, hint=hint, law=": ".join(filter(None, (law, own))), disputed=against)


def _outside(price: Price, beyond: Beyond) -> PriceEntry:
    """An error that no run comes down to: how far they came, and the step at which a trend would get there."""
    finest = f"dt {step(price.finest.dt, price.finest.substeps)}" if price.finest is not None else ""
    best, trend = amount(beyond.at.error, 2), ""
    hint = f"no step down to {finest} and no setting that was run errs so little; the least is {best}, {knobs(beyond.at.track)}"
    if beyond.trend is not None:
        foreseen = f"{amount(1e3 * beyond.trend.dt, 2)} ms"
        trend = f"trend: {foreseen}"
        hint += f"; {knobs(beyond.trend.track)}, of order {amount(beyond.trend.order, 2)}, would at {foreseen}"
    else:
        hint += "; of no setting does the error shrink steadily with the step"
    return PriceEntry(price, f"not by {finest}, best {best}", "", trend, "out", hint)


class Wins(NamedTuple):
    """How many errors each engine reaches at the lowest price, most first, of those where that is known; open: where it is not,
    since intervals meet or the price of another is an upper bound, read off a ladder that ends too early."""

    counts: Sequence[tuple[str, int]]
    open: int

    @property
    def alone(self) -> str:
        """The engine that has answers where no other has any; '' where there are several, or none."""
        return self.counts[0][0] if len(self.counts) == 1 else ""

    @property
    def known(self) -> int:
        """Of how many errors the cheapest is known."""
        return sum(count for _, count in self.counts)


def wins(prices: Sequence[Price]) -> Wins:
    """Of engines to deploy; one without an answer in any scene has lost to nobody."""
    answered = {price.engine for price in prices if price.verdict != "no answer"}
    questions = cheapest([price for price in prices if price.engine in answered])
    counts = counted(standing(questions))
    return Wins(counts, len(questions) - sum(count for _, count in counts))


@dataclass(frozen=True, slots=True, eq=False)
class PricedScene:
    """A case at one set of parameters.

    Terms:
        name: of its chart, unique in the report. unit: what costs count. points: its trials with an error and a cost;
        silent: the rows of those that lack one or both.
    """

    case: str
    where: str
    name: str
    unit: str
    points: Sequence[CostPoint]
    silent: pd.DataFrame


@once
def scenes(store: Store) -> tuple[PricedScene, ...]:
    """All scenes in which something was clocked that has an error."""
    listed: list[PricedScene] = []
    for case, where, trials in priced(store).groups():
        points = priced(store).by_scene.get((case, where), [])
        if any(point.clocked for point in points):
            earlier = sum(scene.case == case for scene in listed)
            name = f"case-{slug(case)}-price" + (f"-{earlier}" if earlier else "")
            silent = trials[~trials["trial"].isin([point.trial for point in points])]
            listed.append(PricedScene(case, where, name, unit_of(trials), points, silent))
    return tuple(listed)
