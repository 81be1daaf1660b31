"""The performance profile: which share of all wanted answers an engine gives within a time, and which case that hangs on.

A wanted answer is a pair of a case and an error that at least one engine reaches which people can deploy; its price is that of
the price list, over the cheapest of such engines. The reference engine stands beside.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

from plumbline.harness.findings.columns import Column, Table, at, plain
from plumbline.harness.findings.prices import PER_SECOND, Price, priced
from plumbline.harness.findings.standing import is_reference
from plumbline.harness.store.rows import grouped

FACTOR, TIME = "times the cheapest", "CPU s per simulated s"
"""The two limits."""
FACTORS = (1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0)
"""Times the cheapest engine."""
SECONDS = tuple(10.0**k for k in range(-7, 3))
"""CPU seconds per simulated second; 1 is real time."""


class SceneName(NamedTuple):
    """A case at one set of parameters; where: these in words, '' where the case has one set."""

    case: str
    where: str

    @property
    def words(self) -> str:
        """'friction_slip_to_roll speed 5.5'."""
        return f"{self.case} {self.where}".strip()


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """How much an engine answers within a limit.

    Terms:
        limit: FACTOR or TIME, within: its value. share: of the pairs. low, high: the least and
        the greatest share when one scene is left out, and without_low, without_high: which one. pairs: how many were put to it.
    """

    engine: str
    limit: str
    within: float
    share: float
    low: float
    high: float
    without_low: SceneName
    without_high: SceneName
    pairs: int


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
            cost = [at(mine[pair], "reached.ratio.value" if limit == FACTOR else "reached.cost.value") for pair in timely]
            for within in values:
                done = [value is not None and value <= within * (1 + 1e-12) for value in cost]
                shares.append(_share(engine, limit, within, [SceneName(case, where) for case, where, _ in timely], done))
    return [share for share in shares if share.pairs]


def _share(engine: str, limit: str, within: float, scenes: Sequence[SceneName], done: Sequence[bool]) -> Share:
    put, answered = Counter(scenes), Counter(scene for scene, its in zip(scenes, done, strict=True) if its)
    left = {scene: (sum(done) - answered[scene]) / (len(done) - count) for scene, count in put.items() if count < len(done)}
    share = sum(done) / len(done) if done else 0.0
    least, most = (extreme(left, key=lambda scene: left[scene], default=SceneName("", "")) for extreme in (min, max))
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


def hinges(rows: Iterable[Share]) -> list[Share]:
    """For each engine and limit the share that depends most on one scene."""
    widest = (max(mine, key=swing) for mine in grouped(rows, attrgetter("engine", "limit")).values())
    return [row for row in widest if swing(row) > 0]


def swing(row: Share) -> float:
    """By how much leaving one scene out changes a share at most."""
    return max(row.share - row.low, row.high - row.share)


def without(row: Share) -> tuple[SceneName, float]:
    """The scene on which a share hangs most, and what the share would be without it."""
    least = row.share - row.low > row.high - row.share
    return (row.without_low, row.low) if least else (row.without_high, row.high)


def sentences(rows: Sequence[Share]) -> list[str]:
    """What the shares are shares of, and which case each engine's share within a factor hangs on."""
    pairs = max((row.pairs for row in rows), default=0)
    lines = [f"Shares of the {pairs} pairs of case and error that at least one engine to deploy reaches."] if pairs else []
    for row in hinges(row for row in rows if row.limit == FACTOR and not is_reference(row.engine)):
        engine, (scene, other) = row.engine, without(row)
        limit = "at the lowest price" if row.within == 1 else f"within {row.within:g} times the lowest price"
        lines.append(
            f"{engine} depends most on {scene.words}: without it, it answers {other:.0%} instead of {row.share:.0%} {limit}."
        )
    return lines


TABLE = Table(
    holds="engine limit within share low high without_low=without_low.words without_high=without_high.words pairs",
    objects=lambda store: profile(priced(store).prices),
    shown=(
        *plain("engine", "within=within:g", "=limit", "share=share:.0%"),
        Column("least, without", lambda row: f"{row.low:.0%} {row.without_low.words}"),
        Column("most, without", lambda row: f"{row.high:.0%} {row.without_high.words}"),
    ),
    sentences=sentences,
)
