"""Steps of worlds with contact and joints, island by island: one after the other, or on several threads."""

from numba import prange

from engine.compile.jit import entry, parallel_entry
from engine.constrain.open_joints import open_joint
from engine.islands.islands import share
from engine.islands.joints import advance_jointed_island, make_room_for_rows
from engine.islands.stages import any_hit, begin_islands, end_islands, next_meeting, skip_sleep
from engine.maths.vec import Floats, Ints
from engine.memory.arena import COUNT, ISLANDS, SPAN_OF_ISLAND, SUBSTEPS, TALLY, THREADS
from engine.memory.carve import ints_of
from engine.memory.status import DONE

__all__ = ["step_islands_jointed", "step_islands_jointed_parallel"]


@entry
def step_islands_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints, one island after the other.

    Returns: as `step_islands`, and `open_joint`.
    """
    stages, tally = ints_of(ints, COUNT)[0, SUBSTEPS] * 2 + 1, ints_of(ints, TALLY)
    for step in range(steps):
        if skip_sleep(floats, ints, steps - step):
            return steps, DONE
        status = begin_islands(floats, ints, keeping=False)
        if status != DONE:
            return step, status
        make_room_for_rows(ints)
        first, hit = 0, 0
        while first < stages:
            end = next_meeting(ints, first)
            for i in range(tally[0, ISLANDS]):
                advance_jointed_island(floats, ints, i, first, end, hit)
            first, hit = end, any_hit(ints)
        status = end_islands(floats, ints)
        if status != DONE:
            return step + 1, status
    return steps, open_joint(floats, ints, touching=True)


@parallel_entry
def step_islands_jointed_parallel(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """As `step_islands_jointed`, to the last bit, with neighbouring islands of about as many contacts on each thread.

    A blow anywhere gives all islands more sweeps, so the threads meet in every sub-step, and twice where surfaces bounce.
    """
    stages, tally, span = ints_of(ints, COUNT)[0, SUBSTEPS] * 2 + 1, ints_of(ints, TALLY), ints_of(ints, SPAN_OF_ISLAND)
    for step in range(steps):
        if skip_sleep(floats, ints, steps - step):
            return steps, DONE
        status = begin_islands(floats, ints, keeping=False)
        if status != DONE:
            return step, status
        make_room_for_rows(ints)
        first, hit = 0, 0
        while first < stages:
            end = next_meeting(ints, first)
            for t in prange(tally[0, THREADS]):
                for i in range(share(span, tally, t), share(span, tally, t + 1)):
                    advance_jointed_island(floats, ints, i, first, end, hit)
            first, hit = end, any_hit(ints)
        status = end_islands(floats, ints)
        if status != DONE:
            return step + 1, status
    return steps, open_joint(floats, ints, touching=True)
