"""A metric: one number read off a trajectory, with its unit and its source."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Integers, Trajectory
from plumbline.harness.trajectory.kinematics import movable


class NotMeasurable(ValueError):
    """The trajectory lacks what the metric reads (a truth, contacts, a stream, enough samples); the text says what."""


@dataclass(frozen=True, slots=True)
class Run:
    """What a metric reads: a scene, what an engine answered, and the truth at the same times, None without one."""

    scene: Scene
    actual: Trajectory
    expected: Trajectory | None = None

    @property
    def movable(self) -> Integers:
        """The places of the bodies that forces move, (n,)."""
        return movable(self.scene)

    @property
    def truth(self) -> Trajectory:
        """The truth, checked to stand at the times of the answer. Raises: NotMeasurable."""
        actual, expected = self.actual, self.expected
        if expected is None:
            raise NotMeasurable("the case has no truth to compare with")
        if expected.p_WB.shape != actual.p_WB.shape:
            raise NotMeasurable(f"truth of shape {expected.p_WB.shape} against an answer of shape {actual.p_WB.shape}")
        if np.size(actual.time) and not np.allclose(expected.time, actual.time, rtol=0.0, atol=1e-9):
            raise NotMeasurable("truth and answer stand at different times")
        return expected


Measure = Callable[[Run], float | Floats | Sequence[float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """One number.

    Terms:
        name: unique, snake case. unit: SI, '1' for none. source: book, paper or definition. better: which way is good.
        verdict: where the name says that something happened (a collapse, a passage), what has to happen for it to count, in
        words; '' for a plain measure. even: does it reckon with steps of one length? Uneven ones are then not measurable.
        impulses: does it need what bodies gave each other in every step, not at samples alone?
        measure: a run to the number, or to numbers of which the largest counts; NaN where one is.
        empty: why nothing can be measured if there are none. finite: is a run that is not finite NaN without being measured?
    """

    name: str
    unit: str
    source: str
    measure: Measure
    better: Literal["lower", "higher"] = "lower"
    verdict: str = ""
    even: bool = False
    impulses: bool = False
    empty: str = "no sample lies in the time that is judged"
    finite: bool = True

    def __call__(self, scene: Scene, actual: Trajectory, expected: Trajectory | None = None) -> float:
        """The number, in the metric's unit. Raises: NotMeasurable."""
        if self.even and not actual.even:
            raise NotMeasurable("it reckons with steps of one length, and those of this run are uneven")
        if self.finite and not actual.finite:
            return float("nan")
        values = np.asarray(self.measure(Run(scene, actual, expected)), dtype=np.float64)
        if values.size == 0:
            raise NotMeasurable(self.empty)
        return float(np.max(values))


def metric(
    unit: str,
    source: str = "",
    *,
    better: Literal["lower", "higher"] = "lower",
    verdict: str = "",
    even: bool = False,
    impulses: bool = False,
    empty: str = "no sample lies in the time that is judged",
    finite: bool = True,
) -> Callable[[Measure], Metric]:
    """The metric that a function measures: named like it, with the source, and the docstring behind it, as its source."""

    def of(measure: Measure) -> Metric:
        words = " ".join((measure.__doc__ or "").split())
        return Metric(
            name=measure.__name__,
            unit=unit,
            source="; ".join(filter(None, (source, words))),
            measure=measure,
            better=better,
            verdict=verdict,
            even=even,
            impulses=impulses,
            empty=empty,
            finite=finite,
        )

    return of
