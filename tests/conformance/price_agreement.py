"""Do two runs of the price study on one machine say the same?  python -m tests.conformance.price_agreement DIR_A DIR_B

Of the ratios to the cheapest engine, how many 95 % intervals overlap; and whether any two engines of which both runs are sure,
by more than 10 %, who is cheaper, change places.
"""

import sys
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from plumbline.harness.findings.prices import Price, Prices
from plumbline.harness.store.store import Store

__all__ = ["Agreement", "agreement"]

SURE = 1.1
Key = tuple[str, str, float]
Agreement = Mapping[str, Any]


def agreement(first: Sequence[Price], second: Sequence[Price]) -> Agreement:
    """Numbers of ratios in both runs and of those that overlap, of sure pairs of engines and those that flipped, in words."""
    sides = [{(p.case, p.where, p.target, p.engine): p for p in prices if p.reached is not None} for prices in (first, second)]
    both = [key for key in sides[0] if key in sides[1]]
    apart = []
    for key in both:
        one, other = sides[0][key], sides[1][key]
        (low, high), (other_low, other_high) = (met.reached.ratio.ends for met in (one, other))
        if low > other_high or other_low > high:
            apart.append(key)
    flips, sure = [], 0
    for question in dict.fromkeys(key[:3] for key in both):
        engines = [key[3] for key in both if key[:3] == question]
        for a, b in combinations(engines, 2):
            verdicts = [order(side[*question, a], side[*question, b]) for side in sides]
            sure += all(verdicts)
            flips += [(*question, a, b)] if verdicts[0] * verdicts[1] < 0 else []
    reached = [set(side) for side in sides]
    return {
        "ratios": len(both),
        "apart": apart,
        "overlap": 1 - len(apart) / len(both) if both else float("nan"),
        "sure pairs": sure,
        "flips": flips,
        "only in one": sorted(reached[0] ^ reached[1]),
    }


def order(a: Price, b: Price) -> int:
    """-1 where a is surely the cheaper by 10 %, 1 where b is, 0 where the intervals leave it open."""
    assert a.high is not None
    assert b.high is not None
    assert a.low is not None
    assert b.low is not None
    return -1 if a.high * SURE < b.low else 1 if b.high * SURE < a.low else 0


if __name__ == "__main__":
    found = agreement(*(Prices(Store(Path(folder))).prices for folder in sys.argv[1:3]))
    print(f"{found['ratios']} ratios in both runs, the intervals of {found['overlap']:.1%} overlap")
    print(f"{found['sure pairs']} pairs of engines of which both runs are sure, {len(found['flips'])} change places")
    for name in ("apart", "flips", "only in one"):
        for key in found[name]:
            print(f"{name}: {' '.join(map(str, key))}")
