"""What a conformance check is, and how it words what it found."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plumbline.harness.adapter import Adapter, Feature, Settings


class NotApplicable(Exception):
    """The check has nothing to ask of this engine, or it refuses by name what is asked; the text says why."""


@dataclass(frozen=True, slots=True)
class CheckResult:
    """What one check found: its verdict, and got against expected in words."""

    status: Literal["passed", "failed", "not_applicable"]
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ConformanceCheck:
    """One question that every adapter must answer rightly.

    Terms:
        name: stable, snake case. run: (adapter, settings of the track) to a finding.
        needs: features without which the question makes no sense; an adapter that does not claim them must refuse them.
        excusable: may an adapter declare a known failure? True for what a vendor's defaults do to the physics; False for
        frames, units, order, finiteness, shapes and the contract itself, which must be right on every track.
    """

    name: str
    question: str
    run: Callable[[Adapter, Settings], CheckResult]
    needs: Feature = Feature.NONE
    excusable: bool = True

    @property
    def subject(self) -> tuple[str, str]:
        """The folder and the file of `checks` that it stands in: ('contact', 'friction')."""
        folder, file = getattr(self.run, "func", self.run).__module__.split(".")[-2:]
        return folder, file


CHECKS: list[ConformanceCheck] = []
"""Every check that is defined so far, in the order of definition; `harness.conformance.CHECKS` are all of them."""

Run = TypeVar("Run", bound=Callable[[Adapter, Settings], CheckResult])


def check(question: str, needs: Feature = Feature.NONE, *, firm: bool = False, name: str = "") -> Callable[[Run], Run]:
    """Define a function as the check of this question.

    Args: firm: it must hold on every track and may not be excused. name: of the check; by default that of the function.
    """

    def define(run: Run) -> Run:
        CHECKS.append(ConformanceCheck(name=name or run.__name__, question=question, run=run, needs=needs, excusable=not firm))
        return run

    return define


@dataclass(frozen=True, slots=True)
class Compared:
    """One comparison of a check, with its verdict in words.

    Terms:
        measured: the text gives numbers and fits whether it holds or not; otherwise it says what is wrong where it does not.
    """

    holds: bool
    text: str
    measured: bool = False


def _worded(value: ArrayLike) -> str:
    array = np.asarray(value, dtype=np.float64)
    return f"{array:.6g}" if array.ndim == 0 else np.array2string(array, precision=6, separator=", ", threshold=12)


def near(what: str, got: ArrayLike, expected: ArrayLike, within: float, because: str = "") -> Compared:
    """Is every number of `got` within `within` of `expected`? NaN is near to nothing."""
    got_array, expected_array = np.asarray(got, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    if got_array.shape != expected_array.shape:
        return Compared(False, f"{what}: got shape {got_array.shape}, expected {expected_array.shape}")
    with np.errstate(all="ignore"):
        holds = bool((np.abs(got_array - expected_array) <= within).all())
    reason = f" ({because})" if because else ""
    return Compared(
        holds, f"{what}: got {_worded(got)}, expected {_worded(expected)} within {within:.3g}{reason}", measured=True
    )


def all_near(*numbers: tuple[str, ArrayLike, ArrayLike, float], because: str) -> list[Compared]:
    """Several comparisons (what, got, expected, within), in words only if one does not hold: numbers take longer to print than
    to compare. NaN is near to nothing."""
    shares = [
        float(np.max(np.abs(np.asarray(got, dtype=np.float64) - np.asarray(expected, dtype=np.float64)), initial=0.0)) / within
        for _, got, expected, within in numbers
    ]
    if all(share <= 1.0 for share in shares):
        return [Compared(True, f"{numbers[0][0]} and more: at most {max(shares):.2g} of what is allowed", measured=True)]
    return [near(what, got, expected, within, because) for what, got, expected, within in numbers]


def that(holds: bool, text: str) -> Compared:
    """A comparison whose verdict is known; `text` says what is wrong where it does not hold: got, expected."""
    return Compared(bool(holds), text)


def judge(*comparisons: Compared) -> CheckResult:
    """Passed when all hold; otherwise failed, naming those that do not."""
    wrong = [comparison.text for comparison in comparisons if not comparison.holds]
    if wrong:
        return CheckResult("failed", "; ".join(wrong))
    return CheckResult(
        "passed", "; ".join(comparison.text for comparison in comparisons if comparison.measured) or "as expected"
    )
