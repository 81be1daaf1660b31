"""The test of all pairs, shared out among threads."""

from numba import prange

from engine.broad.brute_force import search_range
from engine.broad.candidates import add_unbounded, bounds_are_stale, keep_candidates
from engine.broad.parallel.shares import join, new_parts, share
from engine.compile.jit import parallel_entry
from engine.maths.vec import Floats, Ints
from engine.memory.arena import CANDIDATE, COUNT, SHAPES
from engine.memory.carve import ints_of
from engine.memory.status import DONE

__all__ = ["find_candidates"]


@parallel_entry
def find_candidates(floats: Floats, ints: Ints, threads: int) -> int:
    """Find the candidates anew where they are stale. Returns: DONE, or FULL where the arena has no room for them."""
    if not bounds_are_stale(floats, ints):
        return DONE
    candidate, shapes = ints_of(ints, CANDIDATE), ints_of(ints, COUNT)[0, SHAPES]
    part, found = new_parts(candidate, threads)
    for t in prange(threads):
        first, last = share(shapes, threads, t)
        found[t] = search_range(floats, ints, first, last, part[t])
    return keep_candidates(floats, ints, add_unbounded(floats, ints, join(part, found, candidate)))
