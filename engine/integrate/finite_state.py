"""Whether the state is still finite."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats


@kernel
def is_finite(state: Floats, bodies: int) -> bool:
    """Whether every number of the first `bodies` rows is finite."""
    total = 0.0
    for b in range(bodies):
        for c in range(13):
            total += 0.0 * state[b, c]
    return math.isfinite(total)
