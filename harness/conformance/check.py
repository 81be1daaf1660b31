"""What a conformance check is, and how it words what it found."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial, wraps
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from plumbline.harness.adapter import Adapter, Feature, Settings, Unsupported
from plumbline.harness.conformance.engine import Engine
from plumbline.harness.trajectory import Floats


class NotApplicable(Exception):
    """The check has nothing to ask of this engine, or it refuses by name what is asked; the text says why."""


@contextmanager
def refusable(how: str = "refused") -> Iterator[None]:
    """What is asked herein may be refused. Raises: NotApplicable, if it is."""
    try:
        yield
    except Unsupported as refusal:
        raise NotApplicable(f"{how}: {refusal}") from refusal


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
        folder, file = self.run.__module__.split(".")[-2:]
        return folder, file


CHECKS: list[ConformanceCheck] = []
"""Every check that is defined so far, in the order of definition; `harness.conformance.CHECKS` are all of them."""


@dataclass(frozen=True, slots=True)
class Compared:
    """One comparison of a check, with its verdict in words.

    Terms:
        measured: the text gives numbers and fits whether it holds or not; otherwise it says what is wrong where it does not.
    """

    holds: bool
    text: str
    measured: bool = False


Comparisons = Iterator[Compared]
"""What a check yields."""
Asks = Callable[[Engine], Comparisons]


def check(
    question: str, needs: Feature = Feature.NONE, *, firm: bool = False, name: str = "", nothing: str = ""
) -> Callable[[Asks], Asks]:
    """Define a function that yields comparisons as the check of this question; it passes when all of them hold.

    Args: firm: it must hold on every track and may not be excused. name: of the check; by default that of the function.
    nothing: why the check does not apply where there was nothing to compare.
    """

    def define(asks: Asks) -> Asks:
        @wraps(asks)
        def run(adapter: Adapter, settings: Settings) -> CheckResult:
            comparisons = tuple(asks(Engine(adapter, settings)))
            if nothing and not comparisons:
                raise NotApplicable(nothing)
            return judge(*comparisons)

        CHECKS.append(ConformanceCheck(name=name or asks.__name__, question=question, run=run, needs=needs, excusable=not firm))
        return asks

    return define


firm = partial(check, firm=True)
"""The check of a question whose answer may not be excused."""


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


def worst(what: str, got: Floats, expected: Floats, within: float, because: str = "") -> Compared:
    """Is all of an array, infinities apart, near what is expected? NaN is near to nothing."""
    if got.shape != expected.shape:
        return near(what, got, expected, within)
    both = np.isinf(got) & (got == expected)
    off = np.abs(np.where(both, 0.0, got) - np.where(both, 0.0, expected))
    return near(f"worst error of {what}", float(off.max()), 0.0, within, because)


def said(text: str) -> Compared:
    """A comparison that holds, in words that are told."""
    return Compared(True, text, measured=True)


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
