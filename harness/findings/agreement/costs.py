"""What a per cent of error costs each engine in a scene of one's own, in a sentence; none where no limit is agreed."""

from collections.abc import Iterable, Mapping
from operator import itemgetter

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.parameter_words import STEP, beside, in_words
from plumbline.harness.findings.prices import PER_SECOND, Price, Reached, priced
from plumbline.harness.store.store import Store

WITHIN = 1e-2
"""Of the size of what moves; the target of the price list."""


def cost_words(store: Store) -> list[str]:
    """One sentence a scene, the cheapest engine first and our own at the end, as times real time at the settings that do."""
    ours = {name for name, about in store.catalogue.get("engines", {}).items() if about.get("ours")}
    return [sentence for one in agreements(store) if one.agreed and (sentence := _sentence(store, one, store.titles, ours))]


def best_price(store: Store, agreement: Agreement) -> Price | None:
    """The price of what reaches the target cheapest of the engines that people can deploy; None where none does.

    Only a track that agrees with the limit is advised: one that does not may come near it at one step and not at the next.
    """
    agreeing = {(side.engine, side.track) for side in agreement.sides if side.word == "agrees" and not side.ours}
    reaching = [(each.cost.value, p) for p, each in paced(at_target(store, agreement)) if (p.engine, each.at.track) in agreeing]
    return min(reaching, key=itemgetter(0), default=(0.0, None))[1] if agreement.agreed else None


def best_setting(store: Store, agreement: Agreement) -> str:
    """What to set, in a sentence; '' where nothing can be advised."""
    best = best_price(store, agreement)
    if best is None or best.reached is None:
        return ""
    at, title = best.reached.at, store.titles.get(best.engine, best.engine)
    pace = f"{1 / best.reached.cost.value:.3g} times real time at {100 * WITHIN:g} % or less"
    bound = "; larger steps were not tried" if best.verdict == "at most" else ""
    return f"{title}, {at.track} at {in_words({STEP: at.dt})}{beside(at.substeps)}: {pace}{bound}."


def paced(prices: Iterable[Price]) -> list[tuple[Price, Reached]]:
    """Those of targets that are met, the cheapest first."""
    met = [(price, price.reached) for price in prices if price.reached is not None]
    return sorted(met, key=lambda pair: pair[1].cost.value)


def at_target(store: Store, agreement: Agreement) -> list[Price]:
    """The prices of the target in a scene."""
    return [
        price
        for price in priced(store).prices
        if (price.case, price.where) == (agreement.case, agreement.where)
        and price.unit == PER_SECOND
        and abs(price.target / WITHIN - 1) < 1e-9
    ]


def _sentence(store: Store, agreement: Agreement, titles: Mapping[str, str], ours: set[str]) -> str:
    asked = at_target(store, agreement)
    paces = [(price.engine, titles.get(price.engine, price.engine), _pace(each)) for price, each in paced(asked)]
    words = ", ".join(f"{title} {pace}" for engine, title, pace in paces if engine not in ours)
    if not words:
        return ""
    words += "".join(f"; {title}, not ranked, {pace}" for engine, title, pace in paces if engine in ours)
    lacking = [titles.get(p.engine, p.engine) for p in asked if p.reached is None and p.engine not in ours]
    words += f"; not {' nor '.join(lacking)}" if lacking else ""
    until = "" if agreement.until >= 0.999 * agreement.duration else f" up to {agreement.until:.3g} s"
    return f"Times real time on one core at an error of {100 * WITHIN:g} % or less{until}: {words}."


def _pace(reached: Reached) -> str:
    at = reached.at
    return f"{1 / reached.cost.value:.3g} ({at.track}, {in_words({STEP: at.dt})}{beside(at.substeps)})"
