"""How a drive's target or a kinematic body moves: a sinusoid, or straight lines between samples. Both are signals of time."""

import math
from bisect import bisect_right
from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Finite, NonNegative

MOST_SAMPLES = 100_000
"""Samples of one joint: 100 s at a kilohertz."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Sinusoid:
    """amplitude sin(2 pi frequency t + phase), added to the drive's own target.

    Terms:
        amplitude [rad or m]; frequency [Hz]; phase [rad].
    """

    amplitude: Finite
    frequency: NonNegative
    phase: Finite = 0.0
    type: Literal["sinusoid"] = "sinusoid"

    def at(self, time: float, target: float) -> float:
        """The target [rad or m] at a time [s], of a drive with its own `target`."""
        return target + self.amplitude * math.sin(2 * math.pi * self.frequency * time + self.phase)

    def rate_at_start(self) -> float:
        """How fast the target moves at time 0 [rad/s or m/s]."""
        return self.amplitude * 2 * math.pi * self.frequency * math.cos(self.phase)


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Samples:
    """Targets at times, joined by straight lines, in place of the drive's own; before the first and after the last they stay.

    Terms:
        time [s], rising; target [rad or m], as many; of an effort [N m or N]. held: each stays until the next one, without
        lines between them; None: no.
    """

    time: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_SAMPLES)]
    target: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_SAMPLES)]
    held: bool | None = None
    type: Literal["samples"] = "samples"

    def __post_init__(self) -> None:
        if len(self.time) != len(self.target):
            raise ValueError(f"samples: {len(self.time)} times and {len(self.target)} targets, expected as many")
        for k in range(1, len(self.time)):
            if self.time[k] <= self.time[k - 1]:
                raise ValueError(f"samples: time[{k}] is {self.time[k]:g} s after {self.time[k - 1]:g} s, expected later times")

    def at(self, time: float, target: float) -> float:  # noqa: ARG002  both kinds of motion are asked alike
        """The target [rad or m] at a time [s]."""
        after = bisect_right(self.time, time)
        if after in (0, len(self.time)):
            return self.target[0 if after == 0 else -1]
        t, x = self.time, self.target
        if self.held:
            return x[after - 1]
        return x[after - 1] + (x[after] - x[after - 1]) * (time - t[after - 1]) / (t[after] - t[after - 1])

    def rate_at_start(self) -> float:
        """How fast the target moves from time 0 on [rad/s or m/s]."""
        after = bisect_right(self.time, 0.0)
        if self.held or after in (0, len(self.time)):
            return 0.0
        return (self.target[after] - self.target[after - 1]) / (self.time[after] - self.time[after - 1])


Motion = Annotated[Sinusoid | Samples, Field(discriminator="type")]


def sampled(law: Callable[[float], float], end: float, every: float = 1e-3) -> Samples:
    """The samples of a law of time up to `end` [s], one each `every` [s]: any function of one's own as a drive's motion.

    What is between two samples is a straight line, whatever the time step of a run, so that all engines and steps follow one
    signal. Raises: ValueError, for more than MOST_SAMPLES or where the law gives what is no finite number.
    """
    if not (0 < every <= end < math.inf) or end / every >= MOST_SAMPLES:
        raise ValueError(
            f"sampled: every {every!r} s up to {end!r} s, expected 0 < every <= end and at most {MOST_SAMPLES} samples"
        )
    count = math.ceil(end / every - 1e-9)
    times = tuple(every * k for k in range(count + 1))
    return Samples(time=times, target=tuple(float(law(t)) for t in times))
