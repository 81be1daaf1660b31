"""Shares of a loop, one for each thread, and their results put together in the order of the shares.

Each thread writes to rows of its own, and the shares follow one another, so the result is that of one thread.
"""

import numpy as np

from engine.compile.jit import kernel
from engine.maths.vec import Ints

__all__ = ["join", "new_parts", "share"]


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
