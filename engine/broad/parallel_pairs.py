"""The candidates compared by their bounds of this step, shared out among threads."""

from plumbline.engine.broad.candidates import compare_candidates
from plumbline.engine.broad.shares import search_in_shares
from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.status import DONE, FULL


@parallel_entry
def write_pairs(floats: Floats, ints: Ints, threads: int) -> int:
    """As `candidates.write_pairs`."""
    pair, candidate = ints_of(ints, at.PAIR), ints_of(ints, at.CANDIDATE)
    candidates = ints_of(ints, at.PROGRESS)[0, at.CANDIDATES]
    found = search_in_shares(floats, ints, threads, candidates, pair, compare_candidates, candidate)
    ints_of(ints, at.COUNT)[0, at.PAIRS], ints_of(ints, at.TALLY)[0, at.SEARCHED] = found, int(found <= len(pair))
    return FULL if found > len(pair) else DONE
