"""Who says whether a scene needs an effect: the truth of its case, else engines that agree, our own without a vote.

Each engine is a witness on its tuned track: of what leaving an effect out, or taking it in, does to its motion. Where the case
has a motion as its truth, a witness is one that passes as it is and says by how much more it is off the truth then; one is
enough, and ours is asked where nobody else can say. Elsewhere a witness is one that has converged, and at least two that are
not ours have to say the same, and more of them than say the opposite. Where fewer than two such engines were asked, each
speaks for itself, and nobody fails by that.

No witness is an engine that cannot switch the effect. One whose own error hides what another sees does not deny it.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from plumbline.harness.search.needless_effects import (
    TWICE,
    Consequence,
    Scale,
    departure,
    matters,
    scale_by_truth,
    scale_in,
    weighed,
)
from plumbline.harness.store.store import Store

TRUTH, ALONE = "the truth", "alone"
ENOUGH = 2
"""Engines that have to agree where there is no truth."""
Effects = tuple[str, ...]
Scaled = Callable[[Store, Mapping[str, Any]], Scale | None]


@dataclass(frozen=True, slots=True)
class Need:
    """Whether an effect matters.

    Terms: matters: None where that is not known. doubt: why it is not. judge: the truth, the names of those that agree, or
    nobody. against: the names of those that say the opposite.
    """

    matters: bool | None
    doubt: str = ""
    judge: str = ""
    against: tuple[str, ...] = ()


NOBODY = Need(None)


@dataclass(frozen=True, slots=True)
class Word:
    """What one engine says of an effect."""

    consequence: Consequence
    scale: Scale

    @property
    def doubt(self) -> str:
        """Why it does not say whether the effect matters; nothing where it does."""
        return self.consequence.doubt(self.scale)


Words = Mapping[str, Word]


def own_word(store: Store, runs: Mapping[str, Any], run: Any, scale: Scale | None, declared: Collection[str]) -> Word | None:
    """What an engine says of a departure; None where it gave no answer, or cannot switch what the departure is about."""
    departed = departure(run)
    consequence = weighed(departed, matters(store, runs.get(""), run, scale), runs.get(""), run, declared)
    if consequence is None or scale is None:
        return None
    ignored = {notice.effect for trial in (run.trial, runs[""].trial) for notice in store.notices[trial]}
    return None if ignored.intersection(departed.single.names) else Word(consequence, scale)


def heard(
    store: Store, sides: Mapping[str, Mapping[str, Any]], declared: Collection[str], scaled: Scaled
) -> Mapping[Effects, Words]:
    """The words of engines by the effects that they are about.

    Args: sides: an engine's runs by the name of their departure."""
    words: dict[Effects, dict[str, Word]] = {}
    for engine, runs in sides.items():
        scale = scaled(store, runs)
        for run in runs.values() if scale is not None else ():
            if (effects := departure(run).single.names) and (word := own_word(store, runs, run, scale, declared)):
                words.setdefault(effects, {})[engine] = word
    return words


def needs(store: Store, sides: Mapping[str, Mapping[str, Any]], declared: Collection[str]) -> dict[Effects, Need]:
    """By effects, whether they matter; without those of which each engine speaks for itself."""
    ours = {engine for engine in sides if store.described("engines", engine)["ours"]}
    by_truth, by_steps = (heard(store, sides, declared, scaled) for scaled in (scale_by_truth, scale_in))
    found = {}
    for effects in dict.fromkeys((*by_truth, *by_steps)):
        need = judged(by_truth.get(effects, {}), by_steps.get(effects, {}), ours)
        if need.matters is not None or len(sides.keys() - ours) >= ENOUGH:
            found[effects] = need
    return found


def judged(by_truth: Words, by_steps: Words, ours: Collection[str]) -> Need:
    """The verdict on one effect. Args: by_truth, by_steps: what engines say by the truth, and by finer steps."""
    others = {engine: word for engine, word in by_truth.items() if engine not in ours}
    witnesses = others if any(word.consequence.matters is not None for word in others.values()) else by_truth
    need = _majority(witnesses, by_truth, 1)
    if need.matters is not None:
        return Need(need.matters, "", TRUTH, need.against)
    others = {engine: word for engine, word in by_steps.items() if engine not in ours}
    return _majority(others, by_steps, ENOUGH)


def _majority(witnesses: Words, everybody: Words, enough: int) -> Need:
    """What more of the witnesses say, if they are enough. Args: everybody: with those that have no vote."""
    say = {
        what: {engine: word.consequence for engine, word in everybody.items() if word.consequence.matters is what}
        for what in (True, False)
    }
    # What is smaller than twice an engine's own error, that engine does not see.
    seen = min((c.moved for c in say[True].values()), default=float("inf"))
    say[False] = {engine: c for engine, c in say[False].items() if TWICE * c.own < seen}
    votes = {what: [engine for engine in said if engine in witnesses] for what, said in say.items()}
    verdict = len(votes[True]) > len(votes[False])
    if len(votes[verdict]) > len(votes[not verdict]) and len(votes[verdict]) >= enough:
        return Need(verdict, "", ", ".join(votes[verdict]), tuple(say[not verdict]))
    words = [f"{engine} says that it {'matters' if what else 'does not matter'}" for what in say for engine in votes[what]]
    words += [f"{engine}: {word.doubt}" for engine, word in witnesses.items() if word.doubt]
    few = f"fewer than {enough} engines beside ours can say" if len(votes[verdict]) < enough else "engines disagree"
    return Need(None, ": ".join([few, "; ".join(words)] if words else [few]))
