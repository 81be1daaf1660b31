"""A metric: one number read off a trajectory, with its unit and its source."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from harness.scene import Scene
from harness.trajectory import Trajectory


class NotMeasurable(ValueError):
    """The trajectory lacks what the metric reads (a truth, contacts, a stream, enough samples); the text says what."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """One number.

    Terms:
        name: unique, snake case. unit: SI, '1' for none. source: book, paper or definition. better: which way is good.
        verdict: where the name says that something happened (a collapse, a passage), what has to happen for it to count, in
        words; '' for a plain measure. even: does it reckon with steps of one length? Uneven ones are then not measurable.
        impulses: does it need what bodies gave each other in every step, not at samples alone?
        measure: (scene, actual, expected or None) to the number; non-finite input gives a non-finite number, never a good one.
    """

    name: str
    unit: str
    source: str
    measure: Callable[[Scene, Trajectory, Trajectory | None], float]
    better: Literal["lower", "higher"] = "lower"
    verdict: str = ""
    even: bool = False
    impulses: bool = False

    def __call__(self, scene: Scene, actual: Trajectory, expected: Trajectory | None = None) -> float:
        """The number, in the metric's unit. Raises: NotMeasurable."""
        if self.even and not actual.even:
            raise NotMeasurable("it reckons with steps of one length, and those of this run are uneven")
        return float(self.measure(scene, actual, expected))
