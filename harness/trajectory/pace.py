"""How long the steps of a run are: all of them dt, or each dt times a factor of a recorded sequence.

The recorded lengths are divided by their mean, so that dt is the mean step and a whole cycle takes exactly as long as so many
even steps; after the last factor the first follows. Within a cycle the time runs ahead of the even grid and falls behind it:
what is sampled at the ends of steps stands at their true times, which are not evenly spaced.

The lengths of 480 consecutive frames of a loop on a loaded computer, as a clock told them.

Recorded on 25 November 2026 on a virtual machine with two cores (AMD EPYC, Linux 6.18, load average 4.2), 60 frames a second
being nominal: each frame did the same work (60 products and hyperbolic tangents of a matrix of 120 rows, 24 ms when the machine
was busy) and slept until the frame was due, a sixtieth of a second after the one before, or went on at once where it was late.
Two processes beside it worked and slept in turns of .05 to .6 s, drawn at random. Stamps are Python's `time.perf_counter` at
the start of each frame. Nothing is smoothed, sorted or left out. Mean 18056 us, shortest 10184, longest 42644.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from plumbline.harness.trajectory.trajectory import Floats

# fmt: off
LOADED_COMPUTER: Final = (
    19975, 14305, 20394, 22339, 18951, 15996, 15121, 16664, 20224, 13113, 16658, 16683, 16654, 16877, 16515,
    16701, 16679, 16581, 16675, 16673, 20185, 13115, 16661, 16679, 16665, 16667, 24360, 19855, 20512, 19482,
    14068, 22455, 20393, 23113, 13523, 16930, 16598, 16540, 20408, 12938, 16659, 16669, 16667, 20841, 12496,
    16769, 16585, 16668, 16686, 16644, 16651, 16678, 19453, 13866, 16663, 16819, 16693, 19581, 13582, 16799,
    16671, 21369, 23762, 14574, 21655, 19534, 14201, 22264, 23568, 14235, 21731, 16200, 16731, 19063, 14374,
    18302, 16735, 16663, 16673, 16664, 16661, 19933, 13403, 16668, 16675, 16657, 20597, 12738, 16684, 16670,
    16659, 16718, 16663, 16669, 16668, 16665, 16676, 16661, 16662, 16685, 16653, 16626, 16646, 16659, 22350,
    21395, 16734, 18220, 22273, 16759, 16648, 16658, 16670, 20895, 20586, 16733, 18675, 20007, 13155, 16740,
    16666, 16666, 16672, 20097, 13224, 16676, 16658, 16672, 16667, 20107, 13221, 16669, 16663, 16668, 16672,
    20121, 13203, 16671, 16665, 16668, 24786, 15988, 10184, 18244, 16736, 16663, 16667, 16671, 16663, 20169,
    13168, 16659, 16669, 16671, 16663, 20173, 13161, 16665, 16669, 16670, 16662, 17641, 26535, 14248, 27083,
    18669, 20003, 16848, 19145, 17905, 22163, 16735, 16664, 16668, 16666, 21197, 12134, 16668, 19193, 14138,
    16682, 16922, 16558, 19704, 16243, 15976, 15601, 16312, 16015, 16681, 16823, 18363, 17356, 26844, 10297,
    32452, 24911, 30340, 26273, 18237, 26368, 18904, 21436, 18290, 22305, 22285, 20172, 16751, 18005, 15738,
    20378, 14321, 26348, 10599, 17602, 20156, 16734, 16792, 16542, 16675, 16670, 17623, 18590, 13775, 16669,
    16663, 18277, 16729, 24553, 22364, 18274, 34319, 28499, 22310, 18239, 30376, 18944, 16493, 19513, 14204,
    22299, 20203, 17749, 23126, 16765, 16645, 16659, 20374, 15991, 13665, 16671, 16642, 16697, 20318, 12985,
    16670, 19304, 14353, 20690, 12901, 19094, 14060, 16657, 16663, 16650, 16686, 16664, 16665, 17994, 20785,
    24111, 23105, 16946, 19541, 23677, 17083, 19573, 19755, 27411, 15866, 22560, 17274, 21999, 24414, 23252,
    16763, 16659, 16645, 16655, 19640, 16242, 22363, 38463, 18263, 30475, 19791, 16733, 17049, 17795, 19813,
    18299, 16745, 17309, 16092, 16975, 16925, 16144, 16791, 16802, 16957, 16113, 16633, 16674, 16803, 16589,
    16694, 16827, 16467, 19375, 15269, 18272, 16728, 17100, 17860, 18629, 19966, 20189, 17238, 18340, 19841,
    16158, 20414, 17905, 18948, 14589, 17334, 15890, 16672, 16660, 16664, 16663, 16666, 16655, 16657, 16675,
    16659, 19394, 13933, 16667, 16673, 16675, 16653, 19413, 13924, 16661, 16683, 16741, 16602, 16679, 16683,
    16633, 16682, 16745, 16631, 16620, 16690, 16641, 16714, 16709, 16631, 16679, 18669, 18503, 19287, 30546,
    18486, 38484, 22360, 20308, 15997, 13785, 16641, 16664, 16667, 20236, 15999, 16044, 18382, 22730, 16767,
    16655, 16652, 16684, 16651, 16673, 16647, 16663, 16668, 16793, 16554, 16664, 16667, 16714, 16676, 16666,
    16617, 16667, 16720, 16655, 16646, 16637, 16656, 17069, 26427, 18412, 26379, 16727, 22442, 14293, 16734,
    16667, 20312, 14239, 22255, 19505, 13895, 16714, 16630, 16655, 16663, 17758, 15576, 16674, 16686, 16654,
    16654, 17948, 15385, 16678, 16662, 16665, 16660, 16684, 16652, 18379, 16945, 22336, 30529, 30724, 16734,
    16665, 18156, 18372, 30689, 18450, 19622, 16754, 16665, 16738, 16596, 16680, 16648, 16946, 17300, 16738,
    21979, 11527, 18064, 42644, 22480, 26714, 18558, 15089, 16463, 19946, 14106, 16729, 16661, 18563, 16735,
)
# fmt: on
"""Frame lengths [us], in the order in which they came."""


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
