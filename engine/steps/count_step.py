"""The end of every step."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.finite_state import is_finite
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.status import DIVERGED, DONE


@kernel
def count_step(state: Floats, count: Ints) -> int:
    """End a step. Returns: DONE, or DIVERGED."""
    count[0, at.STEPS] += 1
    return DONE if is_finite(state, count[0, at.BODIES]) else DIVERGED
