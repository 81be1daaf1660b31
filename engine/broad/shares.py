"""Shares of a loop, one for each thread, and their results put together in the order of the shares.

Each thread writes to rows of its own, and the shares follow one another, so the result is that of one thread.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import prange

from plumbline.engine.broad.candidates import (
    add_unbounded,
    bounds_are_stale,
    compare_candidates,
    count_pairs,
    count_shapes,
    keep_candidates,
)
from plumbline.engine.compile.jit import kernel, template
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.status import DONE


@kernel
def new_parts(table: Ints, threads: int) -> tuple[Ints, Ints]:
    """A table of pairs for each thread, with as much room as the whole, and the number of pairs in each."""
    return np.empty((threads, len(table), 2), np.int64), np.empty(threads, np.int64)


@kernel
def share(length: int, threads: int, thread: int) -> tuple[int, int]:
    """First and last of the range that a thread works on."""
    return length * thread // threads, length * (thread + 1) // threads


@kernel
def join(part: Ints, found: Ints, table: Ints) -> int:
    """Put the parts one behind the other into the table, as far as it has room. Returns: the number of all pairs."""
    total = 0
    for t in range(len(found)):
        for k in range(min(found[t], len(table) - total)):
            table[total + k, 0], table[total + k, 1] = part[t, k, 0], part[t, k, 1]
        total += found[t]
    return total


@template
def search_in_shares(
    floats: Floats, ints: Ints, threads: int, length: int, table: Ints, search: Callable[..., int], among: Any
) -> int:
    """Write the pairs that a search finds into a table, with a share of the rows that it goes through on each thread.

    Args: length: of what is gone through; search: (floats, ints, first, last, pairs, among) -> number of pairs found; among:
    what it searches: a tuple of tables, a table, or a number.
    Returns: the number of all pairs, perhaps beyond the room.
    """
    part, found = new_parts(table, threads)
    for t in prange(threads):
        first, last = share(length, threads, t)
        found[t] = search(floats, ints, first, last, part[t], among)
    return join(part, found, table)


@template
def search_in_shares_anew(floats: Floats, ints: Ints, build: Callable[..., Any], search: Callable[..., int]) -> int:
    """As `candidates.search_anew`, on the threads of the world."""
    threads, candidate = ints_of(ints, at.TALLY)[0, at.THREADS], ints_of(ints, at.CANDIDATE)
    if bounds_are_stale(floats, ints):
        among = build(floats, ints)
        found = search_in_shares(floats, ints, threads, count_shapes(floats, ints), candidate, search, among)
        status = keep_candidates(floats, ints, add_unbounded(floats, ints, found))
        if status != DONE:
            return status
    candidates, pair = ints_of(ints, at.PROGRESS)[0, at.CANDIDATES], ints_of(ints, at.PAIR)
    return count_pairs(ints, search_in_shares(floats, ints, threads, candidates, pair, compare_candidates, candidate))
