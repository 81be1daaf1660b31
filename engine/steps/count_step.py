"""The end of every step."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import DIVERGED, DONE


@kernel
def count_step(state: Floats, count: Ints) -> int:
    """End a step. Returns: DONE, or DIVERGED where a number of a body's state is not finite."""
    count[0, at.STEPS] += 1
    total = 0.0
    for b in range(count[0, at.BODIES]):
        for c in range(13):
            total += 0.0 * state[b, c]
    return DONE if math.isfinite(total) else DIVERGED
