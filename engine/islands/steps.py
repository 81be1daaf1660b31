"""The loop over the steps of a world that is solved island by island: one after the other, or on several threads."""

from collections.abc import Callable

from numba import prange

from plumbline.engine.compile.jit import template
from plumbline.engine.constrain.stages import Held
from plumbline.engine.islands.contacts import advance_island
from plumbline.engine.islands.islands import share
from plumbline.engine.islands.stages import any_hit, carry_kinematic, end_islands, next_meeting, skip_sleep
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.status import DONE


@template
def in_turn(floats: Floats, ints: Ints, holding: Callable[..., Held], first: int, end: int, hit: int) -> None:
    """Advance all islands, one after the other."""
    for i in range(ints_of(ints, at.TALLY)[0, at.ISLANDS]):
        advance_island(floats, ints, i, first, end, hit, holding)


@template
def on_threads(floats: Floats, ints: Ints, holding: Callable[..., Held], first: int, end: int, hit: int) -> None:
    """As `in_turn`, to the last bit, with neighbouring islands of about as many contacts on each thread."""
    span, tally = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.TALLY)
    for t in prange(tally[0, at.THREADS]):
        for i in range(share(span, tally, t), share(span, tally, t + 1)):
            advance_island(floats, ints, i, first, end, hit, holding)


@template
def step_by_islands(
    floats: Floats,
    ints: Ints,
    steps: int,
    begin: Callable[[Floats, Ints], int],
    run: Callable[..., None],
    holding: Callable[..., Held],
) -> tuple[int, int]:
    """Advance a world by `steps` steps.

    They meet where one has something to tell the others: see `next_meeting`.

    Args: begin: finds the contacts of a step and groups the bodies, as `begin_islands`; run: `in_turn` or `on_threads`;
        holding: holds joints, as `hold`.
    Returns: steps done, and the status of the last one.
    """
    stages = ints_of(ints, at.COUNT)[0, at.SUBSTEPS] * 2 + 1
    for step in range(steps):
        if skip_sleep(floats, ints, steps - step):
            return steps, DONE
        status = begin(floats, ints)
        if status != DONE:
            return step, status
        first, hit = 0, 0
        while first < stages:
            end = next_meeting(ints, first)
            if first % 2 == 1:
                carry_kinematic(floats, ints)
            run(floats, ints, holding, first, end, hit)
            first, hit = end, any_hit(ints)
        status = end_islands(floats, ints)
        if status != DONE:
            return step + 1, status
    return steps, DONE
