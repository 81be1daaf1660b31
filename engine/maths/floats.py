"""Sums and products that are rounded once, and floats as the words that they are.

Nothing else in this package rounds a product together with a sum: a compiler that did so by itself would do it on some
processors only. `fma` is rounded once everywhere, by an instruction or by the C library.
"""

import struct
from collections.abc import Callable
from typing import Any, cast

from plumbline.engine.compile.jit import jit_is_off


def _fma() -> Callable[[float, float, float], float]:
    """The C library's, which rounds once with or without an instruction."""
    import ctypes
    import ctypes.util

    fma = ctypes.CDLL(ctypes.util.find_library("m")).fma
    fma.argtypes, fma.restype = [ctypes.c_double] * 3, ctypes.c_double
    return cast(Callable[[float, float, float], float], fma)


def _word(x: float) -> int:
    return int(struct.unpack("<q", struct.pack("<d", x))[0])


def _from_word(k: int) -> float:
    return float(struct.unpack("<d", struct.pack("<q", k))[0])


def _written() -> tuple[Any, Any, Any]:
    """The same for compiled code."""
    import llvmlite.ir
    import numba
    from numba.extending import intrinsic

    types: Any = numba.types

    @intrinsic
    def fma(_: Any, a: Any, b: Any, c: Any) -> Any:
        """a b + c, rounded once."""

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = [context.cast(builder, *one, types.float64) for one in zip(values, signature.args, strict=True)]
            double = llvmlite.ir.DoubleType()
            kind = llvmlite.ir.FunctionType(double, [double] * 3)
            return builder.call(builder.module.declare_intrinsic("llvm.fma", [double], kind), given)

        return types.float64(a, b, c), code

    @intrinsic
    def word(_: Any, x: Any) -> Any:  # noqa: ARG001
        """The 64 bits of a float."""

        def code(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
            return builder.bitcast(values[0], llvmlite.ir.IntType(64))

        return types.int64(types.float64), code

    @intrinsic
    def from_word(_: Any, k: Any) -> Any:  # noqa: ARG001
        """The float of 64 bits."""

        def code(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
            return builder.bitcast(values[0], llvmlite.ir.DoubleType())

        return types.float64(types.int64), code

    return fma, word, from_word


fma: Callable[[float, float, float], float]
word: Callable[[float], int]
from_word: Callable[[int], float]
fma, word, from_word = (_fma(), _word, _from_word) if jit_is_off() else _written()
