"""The search of the uniform grid, shared out among threads."""

from engine.broad.candidates import bounds_are_stale
from engine.broad.parallel.shares import search_shapes
from engine.broad.uniform_grid import fill_grid, search_range
from engine.compile.jit import parallel_entry
from engine.maths.rows import Floats, Ints
from engine.memory.status import DONE


@parallel_entry
def find_candidates(floats: Floats, ints: Ints, threads: int) -> int:
    """Find the candidates anew where they are stale. Returns: DONE, or FULL where the arena has no room for them."""
    if not bounds_are_stale(floats, ints):
        return DONE
    return search_shapes(floats, ints, threads, search_range, fill_grid(floats, ints))
