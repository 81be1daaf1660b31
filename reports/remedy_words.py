"""Remedies in words: what was changed, where it helps, and what that costs."""

from collections.abc import Mapping, Sequence

from reports.reach import Tally
from reports.text import amount, join_words, plural

__all__ = ["helped", "in_words"]

_WORDS = {
    "sub-steps x 4": "four times the sub-steps",
    "time step / 4": "a quarter of the time step",
    "more iterations": "as many iterations as the engine offers",
    "continuous collision": "continuous collision",
    "damping": "damping of all motion",
}
_PLURAL = ("sub-steps x 4", "more iterations")


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
