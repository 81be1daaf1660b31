"""How much a run folder decides: the share of its prices known by more than a bound, and the winner's share for each purpose.

`python -m tests.decided DIR ...` prints a line for each folder and purpose; of a study that is changed, before and after.
"""

import sys
from pathlib import Path

from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.selection import choose, preset_names, read_preset
from plumbline.harness.findings.standing import is_reference
from plumbline.harness.store.store import Store

__all__ = ["decided"]


def decided(store: Store) -> tuple[int, int, dict[str, tuple[str, float]]]:
    """Prices of engines to deploy that are known by more than a bound, all that these engines have, and who is first in what
    share of resamples by purpose."""
    prices = [price for price in priced(store).prices if price.reached is not None and not is_reference(price.engine)]
    first: dict[str, tuple[str, float]] = {}
    for name in preset_names():
        rank = choose(store, read_preset(name).wish()).rank
        if rank is not None:
            first[name] = rank.places[0].engine, rank.places[0].first
    return sum(price.verdict != "at most" for price in prices), len(prices), first


if __name__ == "__main__":
    for folder in sys.argv[1:]:
        known, of, winners = decided(Store(Path(folder)))
        print(f"{folder}: {known} of {of} prices are known by more than a bound")
        for purpose, (engine, share) in winners.items():
            print(f"  {purpose}: {engine} first in {100 * share:.0f} % of resamples")
