"""The arena's tables, carved inside compiled code.

They are views by address, which nothing counts the users of: the arrays belong to the caller of the entry, who keeps them while
it runs, and no kernel hands a table back to Python.
"""

from typing import Any

import numba
import numpy as np

from engine.compile.compilers import jit_is_off, pointer_maker
from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints
from engine.memory import arena
from engine.memory.arena import FLOAT_TABLES

__all__ = ["floats_of", "ints_of"]

BYTES = 8
"""Of a number."""

compiler: Any = numba
carray = compiler.carray
double_at: Any = None if jit_is_off() else pointer_maker(compiler.float64)
integer_at: Any = None if jit_is_off() else pointer_maker(compiler.int64)


def _float_table(floats: Floats, ints: Ints, k: int) -> Floats:
    """As `arena.float_table`."""
    address = np.intp(floats.ctypes.data) + BYTES * ints[3 * k]
    table: Floats = carray(double_at(address), (ints[3 * k + 1], ints[3 * k + 2]))
    return table


def _int_table(ints: Ints, k: int) -> Ints:
    """As `arena.int_table`."""
    d = 3 * (FLOAT_TABLES + k)
    address = np.intp(ints.ctypes.data) + BYTES * ints[d]
    table: Ints = carray(integer_at(address), (ints[d + 1], ints[d + 2]))
    return table


floats_of = kernel(arena.float_table if jit_is_off() else _float_table)
ints_of = kernel(arena.int_table if jit_is_off() else _int_table)
