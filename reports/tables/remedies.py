"""Remedies: how often each helped, counted and in words, and what that costs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from statistics import median

from plumbline.harness.findings.tables.remedies import Remedied
from plumbline.harness.store.rows import grouped
from plumbline.reports.words.text import amount, join_words, plural

_WORDS = {
    "sub-steps x 4": "four times the sub-steps",
    "time step / 4": "a quarter of the time step",
    "more iterations": "as many iterations as the engine offers",
    "continuous collision": "continuous collision",
    "damping": "damping of all motion",
}
_PLURAL = ("sub-steps x 4", "more iterations")


@dataclass(frozen=True, slots=True)
class Tally:
    """How often a remedy helped, of how many places, and its cost in the middle of those."""

    helped: int
    tried: int
    cost: float | None


def in_words(remedy: str) -> str:
    """What a remedy changes: 'four times the sub-steps', 'the solver sequential impulses'."""
    kind, _, value = remedy.partition(" ")
    return _WORDS.get(remedy) or (
        f"the {kind} {value.replace('_', ' ')}" if kind in ("solver", "integrator") else f"a {remedy}"
    )


def helped(tally: Sequence[tuple[str, Mapping[str, Tally]]]) -> list[str]:
    """A sentence for each remedy that helps somewhere, the most helpful first, and one for all that help nowhere."""
    sentences: list[tuple[float, str]] = []
    nowhere: list[str] = []
    for remedy, by_engine in tally:
        tallies = list(by_engine.values())
        times, tried = sum(one.helped for one in tallies), sum(one.tried for one in tallies)
        costs = sorted(one.cost for one in tallies if one.cost is not None)
        words = in_words(remedy)
        if not times:
            nowhere.append(words)
            continue
        price = f", at {_range(costs)} times the cost" if costs else ""
        verb = "help" if remedy in _PLURAL else "helps"
        sentence = f"{words[0].upper()}{words[1:]} {verb} in {times} of {plural(tried, 'place')}{price}."
        sentences.append((times / tried, sentence))
    listed = [sentence for _, sentence in sorted(sentences, key=lambda pair: -pair[0])]
    return [*listed, *([f"Tried without help anywhere: {join_words(nowhere)}."] if nowhere else [])]


def _range(costs: Sequence[float]) -> str:
    """The least and the most of engines, or one of both."""
    low, high = amount(costs[0], 2), amount(costs[-1], 2)
    return low if low == high else f"{low} to {high}"


def tally(remedies: Sequence[Remedied]) -> list[tuple[str, Mapping[str, Tally]]]:
    """By remedy and engine, how often it helped where it was tried; the most helpful first."""
    answered = [remedied for remedied in remedies if remedied.share_after is not None]
    counted = {
        remedy: {engine: _counted(mine) for engine, mine in grouped(tried, attrgetter("engine")).items()}
        for remedy, tried in grouped(answered, attrgetter("remedy")).items()
    }
    return sorted(counted.items(), key=lambda item: -sum(count.helped for count in item[1].values()))


def _counted(tried: Sequence[Remedied]) -> Tally:
    helped = [remedied for remedied in tried if remedied.verdict == "helps"]
    costs = [remedied.cost_ratio for remedied in helped if remedied.cost_ratio is not None]
    return Tally(len(helped), len(tried), median(costs) if costs else None)
