"""The price list as people read it: a row for each scene and error, a column for each engine."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.prices import PER_SECOND, Price
from reports.costs import titled
from reports.text import amount, duration, power
from reports.work_precision import priced

if TYPE_CHECKING:
    from harness.store import Store

__all__ = ["SHOWN", "Entry", "Line", "heat", "price_list", "wins"]

SHOWN = 1e-2
"""The error that the list shows at first: every scene has a line for it."""
HEATS = ((1.0, "x1"), (2.0, "x2"), (10.0, "x10"), (100.0, "x100"))
"""Times the cheapest, and the shade of a cell up to there."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One price: its words, its shade, and what hovering says."""

    price: Price
    text: str
    ratio: str
    between: str
    shade: str
    hint: str


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
    found: dict[tuple[str, str], dict[float, dict[str, Price]]] = {}
    for price in priced(store).prices:
        found.setdefault((price.case, price.where), {}).setdefault(price.target, {})[price.engine] = price
    lines: list[Line] = []
    for (case, where), targets in found.items():
        title = titled(store, case, where)
        for target, prices in sorted(targets.items(), reverse=True):
            last = target <= SHOWN and all(price.verdict in ("never reached", "no answer") for price in prices.values())
            unit = next(iter(prices.values())).unit
            shown = "" if unit == PER_SECOND else f"per {unit}"
            entries = {engine: entry(price) for engine, price in prices.items()}
            lines.append(Line(case, title, power(round(math.log10(target))), shown, last, entries))
            if last:
                break
    return lines


def heat(price: Price) -> str:
    """The shade of a price: the darkest is the cheapest."""
    if price.ratio is None:
        return "out"
    return next((shade for limit, shade in HEATS if price.ratio <= limit * (1 + 1e-12)), "far")


def entry(price: Price) -> Entry:
    """One price in words."""
    if price.cost is None:
        best = f" (best {amount(price.best_error, 2)})" if price.best_error is not None else ""
        text = f"never{best}" if price.verdict == "never reached" else price.verdict
        return Entry(price, text, "", "", "out", price.reason or f"{price.verdict}{best}; {price.track}")
    sign = {"at most": "≤ ", "within the truth's error": "≈ "}.get(price.verdict, "")
    shown = price.low is not None and price.high is not None and math.isfinite(price.low) and math.isfinite(price.high)
    between = f"{duration(price.low)} to {duration(price.high)}" if shown else ""
    ratio = "" if price.cheapest or price.ratio is None else amount(price.ratio, 3 if price.ratio < 2 else 2)
    hint = f"{price.track}, step {amount(1e3 * (price.dt or math.nan))} ms; {price.verdict}"
    if not price.cheapest and price.ratio_low is not None and price.ratio_high is not None:
        hint += f"; {amount(price.ratio_low)} to {amount(price.ratio_high)} times the cheapest"
    return Entry(price, sign + duration(price.cost), ratio, between, heat(price), hint)


def wins(prices: Sequence[Price]) -> list[tuple[str, int]]:
    """How many errors each engine reaches at the lowest price, most first."""
    counts = {price.engine: 0 for price in prices}
    for price in prices:
        counts[price.engine] += price.cheapest
    return sorted(counts.items(), key=lambda pair: -pair[1])
