"""Restitution out of a spring and a damper: which stiffness and damping rebound by e, over phases of the step."""

import math
from functools import cache

import numpy as np

from plumbline.harness.adapter import Unsupported


def _rebound(z: float, steps: int, fine: int) -> float:
    """Mean restitution over phases of a spring and damper that cannot pull, of damping ratio z, lasting `steps` steps.

    Equation: x'' = max(0, -2 z w x' - w^2 x), stepped by the semi-implicit rule in steps of 1/fine, with
    w = (pi - 2 asin z)/(cos(asin z) steps) below z = 1 and its limit 2/steps above.
    """
    if z < 1 - 1e-9:
        p = math.asin(z)
        w = (math.pi - 2 * p) / (math.cos(p) * steps * fine)
    else:
        w = 2 / (steps * fine)
    phases = (np.arange(128) + 0.5) / 128
    x, v = -phases, np.full(128, -1.0)
    flying = np.zeros(128, dtype=bool)
    for _ in range(40 * steps * fine):
        push = np.where(flying, 0.0, np.maximum(0.0, -2 * z * w * v - w * w * x))
        v = v + push
        x = x + v
        flying |= (x >= 0) | ((push == 0) & (v > 0))
        if flying.all():
            break
    return float(np.where(flying, v, 0.0).mean())


@cache
def elastic(e: float, h: float, steps: int, fine: int) -> tuple[float, float]:
    """solref in its direct form (-stiffness, -damping) per unit mass whose mean rebound is e, by bisection over z.

    Source: MuJoCo, "Modeling", solver parameters (negative solref); the damping ratio is ours.
    """
    low, high = 0.0, steps / 4
    if e < _rebound(high, steps, fine):
        raise Unsupported(f"restitution {e:g}", f"MuJoCo's soft contact rebounds by {_rebound(high, steps, fine):.3f} at least")
    if e >= _rebound(low, steps, fine):
        high = low
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if _rebound(middle, steps, fine) > e else (low, middle)
    p = math.asin(min(low, 1.0))
    w = ((math.pi - 2 * p) / math.cos(p) if low < 1 - 1e-9 else 2.0) / (steps * h)
    return (-w * w, -2 * low * w if low > 0 else -1e-9 * w)
