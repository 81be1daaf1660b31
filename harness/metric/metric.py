"""A metric: one number read off a trajectory, with its unit and its source."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from plumbline.harness.scene import Body, Scene
from plumbline.harness.scene.sensor import Mount
from plumbline.harness.trajectory import Contacts, Floats, Integers, Trajectory
from plumbline.harness.trajectory.kinematics import movable

S = TypeVar("S", bound=Mount)
NO_SAMPLE = "no sample lies in the time that is judged"


class NotMeasurable(ValueError):
    """The trajectory lacks what the metric reads (a truth, contacts, a stream, enough samples); the text says what."""


@dataclass(frozen=True, slots=True)
class Run:
    """What a metric reads: a scene, what an engine answered, and the truth at the same times, None without one.

    All that it may lack it refuses by itself: its properties and methods raise NotMeasurable.
    """

    scene: Scene
    actual: Trajectory
    expected: Trajectory | None = None

    @property
    def movable(self) -> Integers:
        """The places of the bodies that forces move, (n,)."""
        return movable(self.scene)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies of the scene, in the order of their places."""
        return self.scene.bodies

    @property
    def truth(self) -> Trajectory:
        """The truth, checked to stand at the times of the answer."""
        actual, expected = self.actual, self.expected
        if expected is None:
            raise NotMeasurable("the case has no truth to compare with")
        if expected.p_WB.shape != actual.p_WB.shape:
            raise NotMeasurable(f"truth of shape {expected.p_WB.shape} against an answer of shape {actual.p_WB.shape}")
        if np.size(actual.time) and not np.allclose(expected.time, actual.time, rtol=0.0, atol=1e-9):
            raise NotMeasurable("truth and answer stand at different times")
        return expected

    @property
    def contacts(self) -> tuple[Contacts, ...]:
        """The contacts of each sample."""
        if self.actual.contacts is None:
            raise NotMeasurable("no contacts were recorded")
        return self.actual.contacts

    def sensors(self, kind: type[S], words: str) -> tuple[S, ...]:
        """The sensors of a kind. Args: words: what the kind is called, with 'no' before it."""
        sensors = tuple(sensor for sensor in self.scene.sensors if isinstance(sensor, kind))
        if not sensors:
            raise NotMeasurable(f"the scene has {words}")
        return sensors

    def stream(self, name: str) -> Floats:
        """The stream '<sensor>/<channel>', (k, ...) with k > 0."""
        recorded = self.actual.streams.get(name)
        if recorded is None or len(recorded) == 0:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        return recorded

    def true_stream(self, name: str) -> Floats:
        """The truth's stream '<sensor>/<channel>', (k, ...)."""
        if self.expected is None or name not in self.expected.streams:
            raise NotMeasurable(f"the truth has no stream '{name}'")
        return self.expected.streams[name]

    def beside_truth(self, sensor: str, channel: str) -> tuple[Floats, Floats]:
        """The stream '<sensor>/<channel>' and the truth's, (k, ...) each, taken at the same times and of one size."""
        name = f"{sensor}/{channel}"
        recorded, truth = self.stream(name), self.true_stream(name)
        here, there = self.stream(f"{sensor}/time"), self.true_stream(f"{sensor}/time")
        if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
            raise NotMeasurable(f"the truth of '{name}' stands at other times than what was read")
        if recorded.shape != truth.shape:
            raise NotMeasurable(f"stream '{name}' of shape {recorded.shape} against a truth of shape {truth.shape}")
        return recorded, truth


Measure = Callable[[Run], float | Floats | Sequence[float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """One number.

    Terms:
        name: unique, snake case. unit: SI, '1' for none. source: book, paper or definition. better: which way is good.
        verdict: where the name says that something happened (a collapse, a passage), what has to happen for it to count, in
        words; '' for a plain measure. even: does it reckon with steps of one length? Uneven ones are then not measurable.
        contacts: does it read contacts? impulses: does it need what bodies gave each other in every step, not at samples alone?
        measure: a run to the number, or to numbers of which the largest counts; NaN where one is.
        samples: the fewest that it can be measured with. empty: why nothing can be measured if there are no numbers. finite: is
        a run that is not finite NaN without being measured?
    """

    name: str
    unit: str
    source: str
    measure: Measure
    better: Literal["lower", "higher"] = "lower"
    verdict: str = ""
    even: bool = False
    contacts: bool = False
    impulses: bool = False
    samples: int = 1
    empty: str = NO_SAMPLE
    finite: bool = True

    def __call__(self, scene: Scene, actual: Trajectory, expected: Trajectory | None = None) -> float:
        """The number, in the metric's unit. Raises: NotMeasurable."""
        if self.even and not actual.even:
            raise NotMeasurable("it reckons with steps of one length, and those of this run are uneven")
        if self.finite and not actual.finite:
            return float("nan")
        if len(actual) < self.samples:
            raise NotMeasurable(NO_SAMPLE if self.samples == 1 else f"{len(actual)} samples, expected at least {self.samples}")
        values = np.asarray(self.measure(Run(scene, actual, expected)), dtype=np.float64)
        if values.size == 0:
            raise NotMeasurable(self.empty)
        return float(np.max(values))


def metric(unit: str, source: str = "", **terms: Any) -> Callable[[Measure], Metric]:
    """The metric that a function measures: named like it, with the source, and the docstring behind it, as its source.

    Args: terms: the others of a `Metric`.
    """

    def of(measure: Measure) -> Metric:
        words = " ".join((measure.__doc__ or "").split())
        cited = "; ".join(filter(None, (source, words)))
        return Metric(name=measure.__name__, unit=unit, source=cited, measure=measure, **terms)

    return of
