"""Steps of worlds with contact, without joints, island by island: one after the other, or on several threads."""

from plumbline.engine.compile.jit import entry, kernel, parallel_entry
from plumbline.engine.constrain.stages import hold_nothing
from plumbline.engine.islands.stages import begin_islands, in_turn, on_threads, step_by_islands
from plumbline.engine.maths.rows import Floats, Ints


@kernel
def begin(floats: Floats, ints: Ints) -> int:
    """As `begin_islands`: where all bodies are still, the contacts of the last step are kept."""
    return begin_islands(floats, ints, keeping=True)


@entry
def step_islands(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact, one island after the other. Returns: as `step_contact`, or SEARCH_PENDING."""
    return step_by_islands(floats, ints, steps, begin, in_turn, hold_nothing)


@parallel_entry
def step_islands_parallel(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """As `step_islands`, on several threads."""
    return step_by_islands(floats, ints, steps, begin, on_threads, hold_nothing)
