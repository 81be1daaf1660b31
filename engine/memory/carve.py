"""The arena's tables, carved inside compiled code.

They are views by address, which nothing counts the users of: the arrays belong to the caller of the entry, who keeps them while
it runs, and no kernel hands a table back to Python.

A table is ten words to Numba, of which a kernel reads two at most. Carved in place, and not in a function of its own, they are
known when the optimiser looks through all calls, which it does once, before it puts functions in place of calls: what is the
same wherever a kernel is called is then not handed to it. A pendulum's step takes two thirds of the time.
"""

from typing import Any

import numba
import numpy as np

from engine.compile.compilers import jit_is_off, pointer_maker
from engine.compile.jit import inlined
from engine.maths.vec import Floats, Ints
from engine.memory import arena
from engine.memory.arena import FLOAT_TABLES
from engine.memory.layout import FLOATS, INTS

__all__ = ["floats_of", "ints_of"]

BYTES = 8
"""Of a number."""

OPEN = 0
"""In place of a number of columns that the world decides."""

FLOAT_COLUMNS = np.array([table.columns if isinstance(table.columns, int) else OPEN for table in FLOATS])
INT_COLUMNS = np.array([table.columns if isinstance(table.columns, int) else OPEN for table in INTS])
"""The columns of each table, by its number: known where compiled, so that they are not among the words handed on either."""

compiler: Any = numba
carray = compiler.carray
double_at: Any = None if jit_is_off() else pointer_maker(compiler.float64)
integer_at: Any = None if jit_is_off() else pointer_maker(compiler.int64)


def _float_table(floats: Floats, ints: Ints, k: int) -> Floats:
    """As `arena.float_table`."""
    address = np.intp(floats.ctypes.data) + BYTES * ints[3 * k]
    columns = FLOAT_COLUMNS[k] if FLOAT_COLUMNS[k] != OPEN else ints[3 * k + 2]
    table: Floats = carray(double_at(address), (ints[3 * k + 1], columns))
    return table


def _int_table(ints: Ints, k: int) -> Ints:
    """As `arena.int_table`."""
    d = 3 * (FLOAT_TABLES + k)
    address = np.intp(ints.ctypes.data) + BYTES * ints[d]
    columns = INT_COLUMNS[k] if INT_COLUMNS[k] != OPEN else ints[d + 2]
    table: Ints = carray(integer_at(address), (ints[d + 1], columns))
    return table


floats_of = inlined(arena.float_table if jit_is_off() else _float_table)
ints_of = inlined(arena.int_table if jit_is_off() else _int_table)
