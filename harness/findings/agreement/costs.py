"""What a per cent of error costs each engine in a scene of one's own, in a sentence; none where no limit is agreed."""

from collections.abc import Mapping

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.parameter_words import STEP, beside, in_words
from plumbline.harness.findings.prices import PER_SECOND, Price, priced
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
    reaching = [price for price in at_target(store, agreement) if price.cost and (price.engine, price.track) in agreeing]
    return min(reaching, key=lambda price: price.cost or 0.0, default=None) if agreement.agreed else None


def best_setting(store: Store, agreement: Agreement) -> str:
    """What to set, in a sentence; '' where nothing can be advised."""
    if (best := best_price(store, agreement)) is None:
        return ""
    step = "" if best.dt is None else f" at {in_words({STEP: best.dt})}{beside(best.substeps)}"
    title = store.titles.get(best.engine, best.engine)
    pace = f"{1 / (best.cost or 1.0):.3g} times real time at {100 * WITHIN:g} % or less"
    bound = "; larger steps were not tried" if best.verdict == "at most" else ""
    return f"{title}, {best.track}{step}: {pace}{bound}."


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
    paced = sorted((price for price in asked if price.cost), key=lambda price: price.cost or 0.0)
    ranked = [price for price in paced if price.engine not in ours]
    if not ranked:
        return ""
    words = ", ".join(f"{titles.get(price.engine, price.engine)} {_pace(price)}" for price in ranked)
    words += "".join(f"; {titles.get(p.engine, p.engine)}, not ranked, {_pace(p)}" for p in paced if p.engine in ours)
    lacking = [titles.get(price.engine, price.engine) for price in asked if not price.cost and price.engine not in ours]
    words += f"; not {' nor '.join(lacking)}" if lacking else ""
    until = "" if agreement.until >= 0.999 * agreement.duration else f" up to {agreement.until:.3g} s"
    return f"Times real time on one core at an error of {100 * WITHIN:g} % or less{until}: {words}."


def _pace(price: Price) -> str:
    step = "" if price.dt is None else f", {in_words({STEP: price.dt})}{beside(price.substeps)}"
    return f"{1 / (price.cost or 1.0):.3g} ({price.track}{step})"
