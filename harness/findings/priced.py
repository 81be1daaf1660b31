"""The points and prices of a run folder, worked out once for all that ask: they take longer than what is made of them."""

from functools import lru_cache

from plumbline.harness.findings.prices import Prices
from plumbline.harness.store.store import Store


@lru_cache(maxsize=2)
def priced(store: Store) -> Prices:
    """Points and prices of a store; worked out once, when they are first asked for."""
    return Prices(store)
