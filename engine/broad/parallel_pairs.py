"""The candidates compared by their bounds of this step, shared out among threads."""

from engine.broad.candidates import compare_candidates
from engine.broad.shares import search_in_shares
from engine.compile.jit import parallel_entry
from engine.maths.rows import Floats, Ints
from engine.memory import arena as at
from engine.memory.carve import ints_of
from engine.memory.status import DONE, FULL


@parallel_entry
def write_pairs(floats: Floats, ints: Ints, threads: int) -> int:
    """As `candidates.write_pairs`."""
    pair, candidate = ints_of(ints, at.PAIR), ints_of(ints, at.CANDIDATE)
    candidates = ints_of(ints, at.PROGRESS)[0, at.CANDIDATES]
    found = search_in_shares(floats, ints, threads, candidates, pair, compare_candidates, candidate)
    ints_of(ints, at.COUNT)[0, at.PAIRS], ints_of(ints, at.TALLY)[0, at.SEARCHED] = found, 1
    return FULL if found > len(pair) else DONE
