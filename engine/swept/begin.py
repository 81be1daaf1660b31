"""Which contacts a swept step begins with: of fast pairs, only those that touch and do not fly apart."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Vec, load3
from plumbline.engine.maths.vec import add, cross, dot, sub
from plumbline.engine.memory import arena as at

FAST = 2.0
"""A pair that looks farther ahead than so many margins is fast: a swept step finds its time of impact."""
IN_TOUCH = 1e-3
"""Share of the margin within which shapes touch."""


@kernel
def touch_gap(setting: Floats) -> float:
    """The gap [m] below which two shapes touch."""
    return float(max(IN_TOUCH * setting[0, at.MARGIN], 1e-9))


@kernel
def begins(state: Floats, setting: Floats, i: int, j: int, n: Vec, point: Floats, first: int, points: int) -> bool:
    """Whether bodies i and j, a fast pair, have a contact from the start of a swept step, with the points from row `first` on.

    A contact would hold the bodies to the time stepping of the contact solver; a bounce flies on under its own.
    """
    slowest = math.inf
    for k in range(first, first + points):
        x = load3(point, k, at.PLACE)
        vi = add(load3(state, i, at.V), cross(load3(state, i, at.W), sub(x, load3(state, i, at.P))))
        vj = add(load3(state, j, at.V), cross(load3(state, j, at.W), sub(x, load3(state, j, at.P))))
        if point[k, at.FIRST_GAP] <= touch_gap(setting):
            slowest = min(slowest, dot(n, sub(vj, vi)))
    return slowest * float(setting[0, at.WHOLE_STEP]) <= touch_gap(setting) / IN_TOUCH
