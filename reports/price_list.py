"""The price list as people read it: a row for each scene and error, a column for each engine."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from harness.findings.emulations import whose
from harness.findings.prices import PER_SECOND, Price
from reports.costs import titled
from reports.disputes import disputed
from reports.text import TIMES, amount, duration, power
from reports.work_precision import priced

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["SHOWN", "Entry", "Line", "Tried", "heat", "marked", "price_list", "tried", "wins"]

SHOWN = 1e-2
"""The error that the list shows at first: every scene has a line for it."""
HEATS = ((1.0, "x1"), (2.0, "x2"), (10.0, "x10"), (100.0, "x100"))
"""Times the cheapest, and the shade of a cell up to there."""


@dataclass(frozen=True, slots=True)
class Entry:
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


@dataclass(frozen=True, slots=True)
class Line:
    """What one error costs in one scene, by engine; last: does no engine get farther?"""

    case: str
    title: str
    target: str
    unit: str
    last: bool
    entries: Mapping[str, Entry]


def price_list(store: "Store") -> list[Line]:
    """All lines, from coarse to fine; below the first error from `SHOWN` on that no engine reaches nothing is left to say."""
    by_scene: dict[tuple[str, str], dict[float, dict[str, Price]]] = {}
    for price in priced(store).prices:
        by_scene.setdefault((price.case, price.where), {}).setdefault(price.target, {})[price.engine] = price
    lines: list[Line] = []
    for (case, where), targets in by_scene.items():
        title = titled(store, case, where)
        for target, prices in sorted(targets.items(), reverse=True):
            last = target <= SHOWN and all(price.verdict in ("not within the ladder", "no answer") for price in prices.values())
            unit = next(iter(prices.values())).unit
            shown = "" if unit == PER_SECOND else f"per {unit}"
            entries = {engine: marked(store, price) for engine, price in prices.items()}
            lines.append(Line(case, title, power(round(math.log10(target))), shown, last, entries))
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


def tried(store: "Store") -> list[Tried]:
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


def heat(price: Price) -> str:
    """The shade of a price: the darkest is the cheapest."""
    if price.ratio is None:
        return "out"
    return next((shade for limit, shade in HEATS if price.ratio <= limit * (1 + 1e-12)), "far")


def entry(price: Price) -> Entry:
    """One price in words."""
    if price.cost is None:
        if price.verdict == "not within the ladder":
            return _outside(price)
        return Entry(price, price.verdict, "", "", "out", price.reason or f"{price.verdict}; {price.track}")
    paced = price.unit == PER_SECOND
    sign = {"at most": "≥ " if paced else "≤ ", "within the truth's error": "≈ "}.get(price.verdict, "")
    text, between = (f"{amount(1 / price.cost)}{TIMES}" if paced else duration(price.cost)), ""
    if price.low and price.high and math.isfinite(price.low) and math.isfinite(price.high):
        durations = f"{duration(price.low)} to {duration(price.high)}"
        between = f"{amount(1 / price.high)} to {amount(1 / price.low)}{TIMES}" if paced else durations
    ratio = "" if price.cheapest or price.ratio is None else amount(price.ratio, 3 if price.ratio < 2 else 2)
    hint = f"{price.track}, step {amount(1e3 * (price.dt or math.nan))} ms; {price.verdict}"
    if paced:
        hint = f"{duration(price.cost)} of CPU time per simulated second; {hint}"
    if not price.cheapest and price.ratio_low is not None and price.ratio_high is not None:
        hint += f"; {amount(price.ratio_low)} to {amount(price.ratio_high)} times the cheapest"
    return Entry(price, sign + text, ratio, between, heat(price), hint)


def marked(store: "Store", price: Price) -> Entry:
    """One price in words, with whose laws it is about and whether it is disputed; settings have their track's laws."""
    law = whose(store.catalogue, price.engine, price.case, store.bases.get(price.trial, ""))
    against = disputed(store, price.engine, price.case)
    plain = entry(price)
    hint = "; ".join(word for word in (plain.hint, f"{law} by the adapter" if law else "", against) if word)
    return replace(plain, hint=hint, law=law, disputed=against)


def _outside(price: Price) -> Entry:
    """An error that no run comes down to: how far they came, and the step at which a trend would get there."""
    finest, best = f"{amount(1e3 * (price.finest_dt or math.nan))} ms", amount(price.best_error, 2)
    hint = f"no step down to {finest} and no setting that was run errs so little; the least is {best}, {price.track}"
    trend = ""
    if price.foreseen_dt is not None:
        foreseen = f"{amount(1e3 * price.foreseen_dt, 2)} ms"
        trend = f"trend: {foreseen}"
        hint += f"; {price.foreseen_track}, of order {amount(price.foreseen_order, 2)}, would at {foreseen}"
    else:
        hint += "; of no setting does the error shrink steadily with the step"
    return Entry(price, f"not by {finest}, best {best}", "", trend, "out", hint)


def wins(prices: Sequence[Price], yardsticks: Collection[str] = ()) -> list[tuple[str, int]]:
    """How many errors each engine reaches at the lowest price, most first; yardsticks do not count."""
    counts = {price.engine: 0 for price in prices if price.engine not in yardsticks}
    least: dict[tuple[str, str, float], Price] = {}
    for price in prices:
        if price.engine in counts and price.cost is not None:
            pair = price.case, price.where, price.target
            if pair not in least or price.cost < (least[pair].cost or math.inf):
                least[pair] = price
    for price in least.values():
        counts[price.engine] += 1
    return sorted(counts.items(), key=lambda pair: -pair[1])
