"""Which contacts a swept step begins with: of fast pairs, only those that touch and do not fly apart."""

import math

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Vec, add, cross, dot, load3, sub
from engine.memory.arena import FIRST_GAP, MARGIN, PLACE, WHOLE_STEP, P, V, W

__all__ = ["FAST", "begins", "touch_gap"]

FAST = 2.0
"""A pair that looks farther ahead than so many margins is fast: a swept step finds its time of impact."""
IN_TOUCH = 1e-3
"""Share of the margin within which shapes touch."""


@kernel
def touch_gap(setting: Floats) -> float:
    """The gap [m] below which two shapes touch."""
    return float(max(IN_TOUCH * setting[0, MARGIN], 1e-9))


@kernel
def begins(state: Floats, setting: Floats, i: int, j: int, n: Vec, point: Floats, at: int, points: int) -> bool:
    """Whether bodies i and j, a fast pair, have a contact from the start of a swept step, with the points from row `at` on.

    A contact would hold the bodies to the time stepping of the contact solver; a bounce flies on under its own.
    """
    slowest = math.inf
    for k in range(at, at + points):
        x = load3(point, k, PLACE)
        vi = add(load3(state, i, V), cross(load3(state, i, W), sub(x, load3(state, i, P))))
        vj = add(load3(state, j, V), cross(load3(state, j, W), sub(x, load3(state, j, P))))
        if point[k, FIRST_GAP] <= touch_gap(setting):
            slowest = min(slowest, dot(n, sub(vj, vi)))
    return slowest * float(setting[0, WHOLE_STEP]) <= touch_gap(setting) / IN_TOUCH
