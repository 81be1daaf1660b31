"""The arena's tables, carved inside compiled code."""

from engine.compile.jit import kernel
from engine.memory import arena

__all__ = ["floats_of", "ints_of"]

floats_of = kernel(arena.float_table)
ints_of = kernel(arena.int_table)
