"""From a series of errors over time to numbers: its maximum, its root mean square and its last value.

A non-finite value anywhere in the series stays non-finite in each of the three.
"""

from collections.abc import Callable

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory

Series = Callable[[Scene, Trajectory, Trajectory | None], Floats]
"""(scene, actual, expected or None) to errors over time, (t,) or (t, n)."""


def _some(series: Floats) -> Floats:
    if np.size(series) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    return np.asarray(series, dtype=np.float64)


def maximum(series: Floats) -> float:
    """The largest value; NaN where one is NaN."""
    return float(np.max(_some(series)))


def root_mean_square(series: Floats) -> float:
    """sqrt(mean(x^2)); non-finite where one value is."""
    values = _some(series)
    largest = float(np.max(np.abs(values)))
    if not 0.0 < largest < np.inf:
        return largest
    # Scaled so that squares neither overflow nor vanish.
    return largest * float(np.sqrt(np.mean(np.square(values / largest))))


def last(series: Floats) -> float:
    """The largest value of the last instant; non-finite if any earlier one is, since what follows is then no answer."""
    values = _some(series)
    if not np.isfinite(values).all():
        return float("nan")
    return float(np.max(values[-1]))


def matched(actual: Trajectory, expected: Trajectory | None) -> Trajectory:
    """The truth, checked to stand at the times of the answer.

    Raises:
        NotMeasurable: there is none, or it has other times or bodies.
    """
    if expected is None:
        raise NotMeasurable("the case has no truth to compare with")
    if expected.p_WB.shape != actual.p_WB.shape:
        raise NotMeasurable(f"truth of shape {expected.p_WB.shape} against an answer of shape {actual.p_WB.shape}")
    if np.size(actual.time) and not np.allclose(expected.time, actual.time, rtol=0.0, atol=1e-9):
        raise NotMeasurable("truth and answer stand at different times")
    return expected


def three(name: str, unit: str, source: str, series: Series) -> tuple[Metric, Metric, Metric]:
    """Three metrics of one series: '<name>_max', '<name>_rms' and '<name>_final'."""

    def reduced(suffix: str, reduce: Callable[[Floats], float]) -> Metric:
        def measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
            return reduce(series(scene, actual, expected))

        return Metric(name=f"{name}_{suffix}", unit=unit, source=source, measure=measure)

    return reduced("max", maximum), reduced("rms", root_mean_square), reduced("final", last)
