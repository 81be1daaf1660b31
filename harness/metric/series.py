"""From a series of errors over time to numbers: its maximum, its root mean square and its last value.

A non-finite value anywhere in the series stays non-finite in each of the three.
"""

import re
from collections.abc import Callable
from typing import Literal

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run
from plumbline.harness.metric.metric import NO_SAMPLE
from plumbline.harness.statistics.student import wilson_interval
from plumbline.harness.trajectory import Floats

Series = Callable[[Run], Floats]
"""A run to errors over time, (t,) or (t, n)."""


def _some(series: Floats) -> Floats:
    if np.size(series) == 0:
        raise NotMeasurable(NO_SAMPLE)
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


def three(name: str, unit: str, source: str, series: Series) -> tuple[Metric, Metric, Metric]:
    """Three metrics of one series: '<name>_max', '<name>_rms' and '<name>_final'."""
    largest, final = two(name, unit, source, series)
    mean = Metric(name=f"{name}_rms", unit=unit, source=source, measure=lambda run: root_mean_square(series(run)))
    return largest, mean, final


def two(name: str, unit: str, source: str, series: Series) -> tuple[Metric, Metric]:
    """Two metrics of one series: '<name>_max' and '<name>_final'."""
    final = Metric(name=f"{name}_final", unit=unit, source=source, measure=lambda run: last(series(run)))
    return Metric(name=f"{name}_max", unit=unit, source=source, measure=series), final


def proportion(
    name: str,
    source: str,
    verdict: str,
    count: Callable[[Run], tuple[int, int]],
    better: Literal["lower", "higher"] = "lower",
) -> tuple[Metric, Metric, Metric]:
    """Three metrics of a share: '<name>', and the ends '<name>_low' and '<name>_high' of its interval. Args: count: k of n."""

    def share(run: Run) -> float:
        successes, trials = count(run)
        return successes / trials

    def end(suffix: str, side: str, index: int) -> Metric:
        return Metric(
            name=f"{name}_{suffix}",
            unit="1",
            source=f"{side} 95 % bound of Wilson (1927) on {name}",
            measure=lambda run: wilson_interval(*count(run))[index],
            verdict=verdict,
            better=better,
        )

    whole = Metric(name=name, unit="1", source=source, measure=share, verdict=verdict, better=better)
    return whole, end("low", "lower", 0), end("high", "upper", 1)


START = "start_"
"""The streams of another start are named so, with its number: 'start_3/v_WB'."""


def other_starts(run: Run, of: str) -> list[Floats]:
    """A stream of each other start, 'p_WB' (k, n, 3) m say."""
    return [stream for name, stream in run.actual.streams.items() if re.fullmatch(rf"{START}\d+/{of}", name)]
