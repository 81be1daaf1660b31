"""The least that has to be left out: kinds of elements without which something works, and none of which can stay."""

from collections.abc import Callable, Collection, Mapping
from itertools import chain, combinations
from typing import Literal

from plumbline.harness.scene import Scene
from plumbline.harness.study.expressed import Verdict, expressed

Drops = frozenset[str]


def least(works: Callable[[Drops], bool], kinds: Collection[str]) -> Drops | None:
    """A set of kinds that has to go for something to work, of which none can stay: the first in alphabetical order stay first.

    Something works without more wherever it works without less. Returns: None where it does not work without all of them.
    """
    if works(frozenset()):
        return frozenset()
    left_out = frozenset(kinds)
    if not works(left_out):
        return None
    for kind in sorted(kinds):
        if works(left_out - {kind}):
            left_out -= {kind}
    return left_out


def subsets(kinds: Collection[str]) -> list[Drops]:
    """All sets of some of these kinds, the small ones first."""
    ordered = sorted(kinds)
    return [frozenset(each) for each in chain.from_iterable(combinations(ordered, size) for size in range(len(ordered) + 1))]


def least_for(engine: str, scenes: Mapping[Drops, Scene]) -> tuple[Verdict, list[str], str]:
    """What has to be left out for an engine to build a scene, in a process that is given up to it.

    Args: scenes: by what they leave out, one for each set of some kinds. Returns: the verdict, what is left out, and why an
    engine cannot, or what it says of the scene with nothing left out.
    """
    answers: dict[Drops, tuple[Literal["can", "cannot", "unavailable", "failed"], str]] = {}

    def works(drops: Drops) -> bool:
        if drops not in answers:
            answers[drops] = expressed(engine, scenes[drops])
        return answers[drops][0] == "can"

    everything = max(scenes, key=len)
    drops = least(works, everything)
    if drops is None:
        verdict, reason = answers[everything]
        return verdict, [], reason
    return "can", sorted(drops), answers[frozenset()][1] if drops else ""
