"""The compiled scaling of a contact problem, as `Scaled` describes it."""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats


@kernel
def scale_problem(w: Floats, q: Floats, friction: Floats, scaled_w: Floats, scaled_q: Floats, scale: Floats) -> float:
    """Write the scaled form of a problem. Args: as of `Problem` and `Scaled`. Returns: the unit of the free velocities."""
    k, unit = len(q), 0.0
    per = np.zeros((k, 3))  # 1/scale; zero where a component is held at zero
    for i in range(k):
        mu, sizes = friction[i], w[3 * i, 3 * i]
        if mu > 0.0:
            sizes = (sizes / (mu * mu) + w[3 * i + 1, 3 * i + 1] + w[3 * i + 2, 3 * i + 2]) / 3.0
        scale[i, 0] = math.sqrt(sizes) * (mu if mu > 0.0 else 1.0)
        scale[i, 1] = scale[i, 2] = math.sqrt(sizes)
        for c in range(3 if mu > 0.0 else 1):
            per[i, c] = 1.0 / scale[i, c]
        for c in range(3):
            scaled_q[i, c] = q[i, c] * per[i, c]
            unit = max(unit, abs(scaled_q[i, c]))
    unit = unit if unit > 0.0 else 1.0
    for i in range(k):
        for c in range(3):
            scaled_q[i, c] /= unit
            for j in range(k):
                for d in range(3):
                    scaled_w[3 * i + c, 3 * j + d] = w[3 * i + c, 3 * j + d] * (per[i, c] * per[j, d])
    return unit


@entry
def write_scaled(w: Floats, q: Floats, friction: Floats, scaled_w: Floats, scaled_q: Floats, scale: Floats) -> float:
    """As `scale_problem`, from Python."""
    return scale_problem(w, q, friction, scaled_w, scaled_q, scale)
