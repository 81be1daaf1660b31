"""The candidates compared by their bounds of this step, shared out among threads."""

from numba import prange

from engine.broad.candidates import compare_candidates
from engine.broad.parallel.shares import join, new_parts, share
from engine.compile.jit import parallel_entry
from engine.maths.vec import Floats, Ints
from engine.memory.arena import CANDIDATES, COUNT, PAIR, PAIRS, PROGRESS, SEARCHED, TALLY
from engine.memory.carve import ints_of

__all__ = ["write_pairs"]


@parallel_entry
def write_pairs(floats: Floats, ints: Ints, threads: int) -> int:
    """As `candidates.write_pairs`."""
    pair, candidates = ints_of(ints, PAIR), ints_of(ints, PROGRESS)[0, CANDIDATES]
    part, found = new_parts(pair, threads)
    for t in prange(threads):
        first, last = share(candidates, threads, t)
        found[t] = compare_candidates(floats, ints, first, last, part[t])
    total = join(part, found, pair)
    ints_of(ints, COUNT)[0, PAIRS], ints_of(ints, TALLY)[0, SEARCHED] = total, 1
    return 2 if total > len(pair) else 0
