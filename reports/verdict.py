"""The verdict matrix: how the trials of each case, engine and track ended."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.own_scenes import by_case, chips
from reports.status import STATUSES, Outcome, outcome, worst

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["Verdict", "totals", "verdicts"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcomes of one cell: (outcome, count) from good to bad, the worst of them, and why it was not better."""

    counts: tuple[tuple[Outcome, int], ...]
    worst: Outcome
    reason: str

    @property
    def trials(self) -> int:
        """How many trials stand behind the cell."""
        return sum(count for _, count in self.counts)


def verdicts(store: "Store") -> dict[tuple[str, str, str], Verdict]:
    """Verdicts by (case, engine, track); a cell without a trial has no entry."""
    cells = {}
    for key, group in store.asked.groupby(["case", "engine", "track"], sort=False):
        bad = worst(group["status"])
        reasons = [reason for status, reason in zip(group["status"], group["reason"], strict=True) if outcome(status) == bad]
        cells[key] = Verdict(counted(Counter(group["status"])), bad, str(reasons[0]))
    # That all numbers of a scene of one's own are finite is no verdict on it.
    return cells | {key: Verdict(((word, 1),), word, sentence) for key, (word, sentence) in chips(store).items()}


def totals(store: "Store") -> Mapping[tuple[str, str], Mapping[str, int]]:
    """Counts of every status by (engine, track), zeros included, over the cases whose checks say what is right."""
    judged = store.asked[~store.asked["case"].isin(list(by_case(store)))]
    rows = judged.groupby(["engine", "track", "status"], sort=False).size()
    counts: dict[tuple[str, str], dict[str, int]] = {}
    for (engine, track, status), count in rows.items():
        counts.setdefault((engine, track), dict.fromkeys(STATUSES, 0))[outcome(status).name] = int(count)
    return counts


def counted(counts: Mapping[str, int]) -> tuple[tuple[Outcome, int], ...]:
    """Counts from good to bad."""
    return tuple(sorted(((outcome(name), count) for name, count in counts.items()), key=lambda pair: pair[0].rank))
