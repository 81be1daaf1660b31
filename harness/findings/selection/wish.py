"""What a user wants of an engine: weights of criteria and of cases, and requirements that leave engines out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

CRITERIA: Mapping[str, str] = {
    "accuracy": "1 up to the error asked for, 0 from ten times it on, on a log scale; other checks by their bounds",
    "speed": "at the error asked for if steps on both sides of it were run, else of the cheapest run that passes all checks "
    "(without one, of the most accurate); 1 for the fastest engine, 0 for a hundredth of its speed",
    "limits": "how far a case can be made harder before it breaks, from easy (0) to extreme (1)",
    "robustness": "the share of runs with an answer, of three runs of a case or more: none diverged, crashed or hung",
    "determinism": "the share of repetitions with the same bits, of those that must have them",
    "capability": "the share of cases that the engine can express",
}
"""By name, what each is measured by."""


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What is wanted.

    weights: by criterion, 0 or more; those left out weigh 1. cases: patterns of case names to weights; the first that matches
    counts, a case that none matches does not; all cases count alike where there is no pattern. features: that an engine has to
    claim. max_error: the error asked for, a share of each case's scale. strict: is an engine left out that does not reach
    it in each case? realtime: how many times faster than real time it has to reach it; None for as slow as it likes. licences:
    SPDX identifiers, of which an engine must have one. platform: that it must run on. with_reference: does the
    reference engine stand in the rank?"""

    weights: Mapping[str, float] = field(default_factory=dict)
    cases: Mapping[str, float] = field(default_factory=dict)
    features: tuple[str, ...] = ()
    max_error: float = 1e-2
    strict: bool = False
    realtime: float | None = None
    licences: tuple[str, ...] = ()
    platform: str = ""
    with_reference: bool = False

    def weight(self, criterion: str) -> float:
        """Of a criterion."""
        return self.weights.get(criterion, 1.0)

    def weight_of_case(self, case: str, family: str) -> float:
        """Of a case; 0 where it does not count."""
        if not self.cases:
            return 1.0
        return next((weight for pattern, weight in self.cases.items() if _matches(case, family, pattern)), 0.0)


def _matches(case: str, family: str, pattern: str) -> bool:
    return pattern == family or fnmatchcase(case, pattern)


@dataclass(frozen=True, kw_only=True)
class Dropped:
    """An engine that is left out. requirement: which it does not meet. value: what it has instead. case, trial: where that was
    seen, '' where it is of the engine itself."""

    engine: str
    requirement: str
    value: str
    case: str = ""
    trial: str = ""
