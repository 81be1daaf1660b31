"""How long the steps of a run are: all of them dt, or each dt times a factor of a recorded sequence.

The recorded lengths are divided by their mean, so that dt is the mean step and a whole cycle takes exactly as long as so many
even steps; after the last factor the first follows. Within a cycle the time runs ahead of the even grid and falls behind it:
what is sampled at the ends of steps stands at their true times, which are not evenly spaced.
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.trajectory.recorded_frames import LOADED_COMPUTER
from plumbline.harness.trajectory.trajectory import Floats

PACES = {"loaded": LOADED_COMPUTER}
"""Recorded sequences of lengths, in any unit, by name."""


@dataclass(frozen=True, slots=True, eq=False)
class Pace:
    """The clock of a run. Terms: dt [s]: the mean step. factors (n,) of mean 1, used in turns; None for even steps."""

    dt: float
    factors: Floats | None = None

    @classmethod
    def of(cls, name: str, dt: float) -> "Pace":
        """The recorded sequence of that name about a mean step dt [s]; even steps for ''."""
        if not name:
            return cls(dt)
        lengths = np.array(PACES[name], dtype=np.float64)
        return cls(dt, lengths / lengths.mean())

    @property
    def even(self) -> bool:
        """Are all steps of one length?"""
        return self.factors is None

    @property
    def longest(self) -> float:
        """The longest step [s]."""
        return self.dt if self.factors is None else self.dt * float(self.factors.max())

    def length(self, step: int) -> float:
        """How long step number `step` is [s]."""
        return self.dt if self.factors is None else self.dt * float(self.factors[step % len(self.factors)])

    def time(self, steps: int) -> float:
        """The time after so many steps [s]."""
        if self.factors is None:
            return steps * self.dt
        cycles, rest = divmod(steps, len(self.factors))
        return self.dt * (cycles * len(self.factors) + float(self.factors[:rest].sum()))

    def span(self, step: int, count: int) -> float:
        """How long `count` steps from number `step` on take [s]."""
        return count * self.dt if self.factors is None else self.time(step + count) - self.time(step)

    def steps(self, time: float) -> int:
        """The step at whose end the time [s] stands, the nearest one."""
        about = round(time / self.dt)
        if self.factors is None:
            return about
        reach = len(self.factors)
        ends = np.array([self.time(step) for step in range(max(0, about - reach), about + reach)])
        return max(0, about - reach) + int(np.abs(ends - time).argmin())

    def since(self, step: int) -> "Pace":
        """The same clock, set to 0 when `step` steps are done."""
        return self if self.factors is None else Pace(self.dt, np.roll(self.factors, -step))
