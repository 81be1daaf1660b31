"""The price list on engines whose price of an error is known: it is found within three per cent, at every target."""

import pytest

from plumbline.harness.findings.tables import price
from tests.known_prices import LAWS, KnownPrices

CLOSE = 0.03


def test_the_price_list_finds_the_planted_prices_and_their_ratio(known_prices: KnownPrices) -> None:
    """The case's scale is 1 m, so that its targets are metres."""
    rows = {(row["engine"], row["target"]): row for row in price.TABLE.rows(known_prices.store)}
    targets = sorted({target for _, target in rows})
    priced = 0
    for engine in {engine for engine, _ in LAWS}:
        for target in targets:
            row, known = rows[engine, target], known_prices.price(engine, target)
            if known is None:
                assert (row["verdict"], row["cost"]) == ("not within the ladder", None)
                continue
            priced += 1
            assert row["cost"] == pytest.approx(known, rel=CLOSE)
            assert row["low"] * (1 - CLOSE) <= known <= row["high"] * (1 + CLOSE)
            cheapest = min(cost for name in ("spinner", "laggard") if (cost := known_prices.price(name, target)) is not None)
            assert row["ratio"] == pytest.approx(known / cheapest, rel=CLOSE)
            assert row["cheapest"] == (engine == "spinner")
    # Orders 1, 2 and 4 of the one reach 5e-6 m, orders 1 and 2 of the other 3e-4 m: targets of 0.1 m to 1e-5 and to 1e-3 m.
    assert priced == 5 + 3
