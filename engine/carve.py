"""The arena's tables, carved inside compiled code."""

from engine import arena
from engine.jit import kernel

__all__ = ["floats_of", "ints_of"]

floats_of = kernel(arena.float_table)
ints_of = kernel(arena.int_table)
