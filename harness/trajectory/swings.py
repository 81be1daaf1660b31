"""To and fro: how often a coordinate turns round, and how far it goes."""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.trajectory.trajectory import Floats

COUNTS = 0.1
"""Of the whole range: what turns back by less only settles."""


@dataclass(frozen=True, slots=True)
class Swing:
    """Terms: turns: how often it turned round. range: between its ends, in the unit of the coordinate; gone: from its start to
    where it stops, or all of the range where it comes back by more than half of that. begun: the sample at which it had first
    moved by the least that counts."""

    turns: int
    range: float
    gone: float
    begun: int


def swing(x: Floats, least: float) -> Swing | None:
    """Of a coordinate (t,); None where it goes no further than `least`."""
    span = float(np.ptp(x))
    if not span > least:
        return None
    back = max(least, COUNTS * span)
    turns, low, high, rising = 0, x[0], x[0], None
    for value in x:
        low, high = min(low, value), max(high, value)
        if rising is not False and high - value > back:
            turns, rising, low = turns + (rising is True), False, value
        elif rising is not True and value - low > back:
            turns, rising, high = turns + (rising is False), True, value
    net = float(abs(x[-1] - x[0]))
    return Swing(turns, span, net if net > span / 2 else span, int(np.flatnonzero(np.abs(x - x[0]) > least)[0]))
