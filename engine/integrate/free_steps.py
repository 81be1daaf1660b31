"""The steps of a world in which nothing touches: one loop for all integrators that know free bodies alone."""

from collections.abc import Callable
from typing import Any

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED
from plumbline.engine.memory.tables import bodies_of
from plumbline.engine.steps.count_step import count_step


@kernel
def advance_free(floats: Floats, ints: Ints, steps: int, advance: Callable[..., bool], *room: Any) -> tuple[int, int]:
    """Advance all bodies by `steps` steps, sub-step by sub-step.

    Args: advance: (bodies, principal, setting, b, h [s], gyroscopic, *room) -> whether body b was advanced by h.
    Returns: steps done, and DONE, or DIVERGED, or UNSOLVED if a body was not advanced.
    """
    bodies, principal = bodies_of(floats, ints), floats_of(floats, ints, at.PRINCIPAL)
    setting = floats_of(floats, ints, at.SETTING)
    count = ints_of(ints, at.COUNT)
    h, gyroscopic = setting[0, at.DT] / count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    for step in range(steps):
        advanced = True
        for _ in range(count[0, at.SUBSTEPS]):
            for b in range(count[0, at.BODIES]):
                if not advance(bodies, principal, setting, b, h, gyroscopic, *room):
                    advanced = False
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
        if not advanced:
            return step + 1, UNSOLVED
    return steps, DONE
