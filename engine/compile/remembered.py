"""What operations return, by the types of what they are given, looked up once a process.

Numba tries all alternatives of an operation anew wherever it stands, and words each that does not fit: a tenth of the time of
a first step.
"""

import operator
from typing import Any

import numba
import numpy as np

__all__ = ["Remembering"]

types: Any = numba.types

ANSWERS: dict[Any, tuple[Any, Any, Any]] = {}
"""By operation and types of arguments: the alternatives that it had, its signature, and which of them that is of."""

ROOMS = frozenset({np.empty, np.zeros})
"""What makes arrays: one function each of Numba's for every shape with a constant in it, unless it is told of numbers."""


def plain_shape(kind: Any) -> Any:
    """A shape as numbers, whichever of them are known."""
    if not isinstance(kind, types.BaseTuple):
        return types.unliteral(kind)
    return types.BaseTuple.from_types(tuple(types.unliteral(one) for one in kind.types))


class Remembering:
    """What Numba knows of types, with the answers to what it was asked before."""

    def __init__(self, known: Any) -> None:
        self._known = known

    def __getattr__(self, name: str) -> Any:
        return getattr(self._known, name)

    def resolve_function_type(self, function: Any, args: Any, kws: Any) -> Any:
        """The signature of a call. Numba tries all alternatives of an operation anew wherever it stands."""
        kind = function if isinstance(function, types.Type) else self._known._lookup_global(function)
        if kws or not isinstance(kind, types.Function):
            return self._known.resolve_function_type(function, args, kws)
        if kind.typing_key in ROOMS:
            args = (plain_shape(args[0]), *args[1:])
        key = kind.typing_key, args
        answer = ANSWERS.get(key)
        if answer is None or answer[0] is not kind.templates:
            signature = self._known.resolve_function_type(function, args, kws)
            if signature is not None:
                ANSWERS[key] = kind.templates, signature, kind.get_impl_key(signature)
            return signature
        _, signature, made = answer
        kind._impl_keys[signature.args] = made
        return signature

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        """The signature of what is put into something."""
        return self.resolve_function_type(operator.setitem, (target, index, value), {})
