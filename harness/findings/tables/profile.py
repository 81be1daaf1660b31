"""The performance profile: which share of all wanted answers an engine gives within a time, and which case that hangs on.

A wanted answer is a pair of a case and an error that at least one engine reaches which people can deploy; its price is that of
the price list, over the cheapest of such engines. The reference engine stands beside.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

from harness.findings.leads import REFERENCE
from harness.findings.priced import priced
from harness.findings.prices import PER_SECOND, Price
from harness.store.store import Store

__all__ = ["BRIEF", "COLUMNS", "FACTOR", "TIME", "Share", "brief", "hinges", "profile", "rows", "sentences", "without"]

FACTOR, TIME = "times the cheapest", "CPU s per simulated s"
"""The two limits."""
FACTORS = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0)
"""Times the cheapest engine."""
SECONDS = tuple(10.0**k for k in range(-7, 3))
"""CPU seconds per simulated second; 1 is real time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """How much an engine answers within a limit.

    Terms:
        limit: FACTOR or TIME, within: its value. share: of the pairs. low, high: the least and
        the greatest share when one case is left out, and without_low, without_high: which one. pairs: how many were put to it.
    """

    engine: str
    limit: str
    within: float
    share: float
    low: float
    high: float
    without_low: str
    without_high: str
    pairs: int


COLUMNS = tuple(field.name for field in fields(Share))


def profile(prices: Sequence[Price]) -> list[Share]:
    """All shares.

    Source: E. D. Dolan & J. J. More, Benchmarking optimization software with performance profiles, Mathematical Programming 91
    (2002) 201; the factor's share is theirs, with leaving cases out in turn beside it.
    """
    reached = dict.fromkeys((p.case, p.where, p.target) for p in prices if p.cheapest)
    shares = []
    for engine in dict.fromkeys(p.engine for p in prices):
        mine = {(p.case, p.where, p.target): p for p in prices if p.engine == engine}
        for limit, values in ((FACTOR, FACTORS), (TIME, SECONDS)):
            put = [pair for pair in reached if pair in mine]
            timely = [pair for pair in put if limit != TIME or mine[pair].unit == PER_SECOND]
            cost = [mine[pair].ratio if limit == FACTOR else mine[pair].cost for pair in timely]
            for within in values:
                done = [value is not None and value <= within * (1 + 1e-12) for value in cost]
                shares.append(_share(engine, limit, within, [f"{case} {where}".strip() for case, where, _ in timely], done))
    return [share for share in shares if share.pairs]


def _share(engine: str, limit: str, within: float, cases: Sequence[str], done: Sequence[bool]) -> Share:
    put, answered = Counter(cases), Counter(case for case, its in zip(cases, done, strict=True) if its)
    left = {case: (sum(done) - answered[case]) / (len(done) - count) for case, count in put.items() if count < len(done)}
    share = sum(done) / len(done) if done else 0.0
    least, most = min(left, key=lambda case: left[case], default=""), max(left, key=lambda case: left[case], default="")
    return Share(
        engine=engine,
        limit=limit,
        within=within,
        share=share,
        low=left.get(least, share),
        high=left.get(most, share),
        without_low=least,
        without_high=most,
        pairs=len(done),
    )


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    return [asdict(share) for share in profile(priced(store).prices)]


BRIEF = ("engine", "within", "", "share", "least, without", "most, without")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    return [
        row["engine"],
        f"{row['within']:g}",
        row["limit"],
        f"{row['share']:.0%}",
        f"{row['low']:.0%} {row['without_low']}",
        f"{row['high']:.0%} {row['without_high']}",
    ]


def hinges(shares: Sequence[Share]) -> list[Share]:
    """For each engine and limit the share that depends most on one case."""
    widest: dict[tuple[str, str], Share] = {}
    for share in shares:
        key = (share.engine, share.limit)
        if key not in widest or swing(share) > swing(widest[key]):
            widest[key] = share
    return [share for share in widest.values() if swing(share) > 0]


def swing(share: Share) -> float:
    """By how much leaving one case out changes a share at most."""
    return max(share.share - share.low, share.high - share.share)


def without(share: Share) -> tuple[str, float]:
    """The case on which a share hangs most, and what it would be without it."""
    least = share.share - share.low > share.high - share.share
    return (share.without_low, share.low) if least else (share.without_high, share.high)


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the shares are shares of, and which case each engine's share within a factor hangs on."""
    pairs = max((row["pairs"] for row in rows), default=0)
    lines = [f"Shares of the {pairs} pairs of case and error that at least one engine to deploy reaches."] if pairs else []
    for share in hinges([Share(**row) for row in rows if row["limit"] == FACTOR and row["engine"] != REFERENCE]):
        case, other = without(share)
        limit = "at the lowest price" if share.within == 1 else f"within {share.within:g} times the lowest price"
        lines.append(
            f"{share.engine} depends most on {case}: without it, it answers {other:.0%} instead of {share.share:.0%} {limit}."
        )
    return lines
