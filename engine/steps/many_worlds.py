"""Advance many worlds in one compiled call, by the address of the step that each of them would run alone.

Calling a compiled step through its address keeps this loop small: it is compiled once for all kinds of worlds, in about a
second, and the machine code that a world runs is the same with others beside it.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, cast

import llvmlite.ir
import numba
from numba import prange

from plumbline.engine.compile.jit import entry, jit_is_off, kernel, linker, parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory.status import CONVEX_PENDING, DONE, SEARCH_PENDING

types: Any = numba.types
FLOATS, INTS = types.Array(types.float64, 1, "C"), types.Array(types.int64, 1, "C")
STEP = types.UniTuple(types.int64, 2)(FLOATS, INTS, types.int64)
"""Of a step: (floats, ints, steps) -> steps done, status."""
SEARCH = types.int64(FLOATS, INTS)
"""Of a broad phase: (floats, ints) -> status."""
COLLIDE = types.none(FLOATS, INTS)
"""Of a narrow phase, or of a test of pairs: (floats, ints)."""


def address_of(function: Any, signature: Any) -> Any:
    """Where the machine code of a compiled function with this signature lies; the function itself where nothing is compiled."""
    if jit_is_off():
        return function
    if linker() is None:
        return _called_apart(function, signature).address
    returned, address = linker().entry_point(function, signature)
    if returned != signature.return_type:
        raise TypeError(f"{function.__name__} returns {returned}, expected {signature.return_type}")
    return address


@cache
def _called_apart(function: Any, signature: Any) -> Any:
    """A function as Numba compiles it for callers that are not its own; kept, for its machine code goes with it."""
    compiled = numba.cfunc(signature)
    if len(signature.args) == 3:
        return compiled(lambda floats, ints, steps: function(floats, ints, steps))
    return compiled(lambda floats, ints: function(floats, ints))


def _caller(signature: Any) -> Callable[..., Any]:
    """How compiled code calls a function of this signature: by its address, with a tuple of arguments."""
    if jit_is_off():
        return lambda function, arguments: function(*arguments)
    from numba.extending import intrinsic

    @intrinsic
    def call(_: Any, address: Any, arguments: Any) -> Any:
        def code(context: Any, builder: Any, _: Any, values: Any) -> Any:
            words = [context.get_value_type(one) for one in signature.args]
            kind = llvmlite.ir.FunctionType(context.get_value_type(signature.return_type), words)
            given = [
                context.cast(builder, builder.extract_value(values[1], k), arguments[k], asked)
                for k, asked in enumerate(signature.args)
            ]
            answer = builder.call(builder.inttoptr(values[0], kind.as_pointer()), given)
            return context.get_dummy_value() if signature.return_type == types.none else answer

        return signature.return_type(address, arguments), code

    return cast(Callable[..., Any], call)


call_step, call_search, call_collide = _caller(STEP), _caller(SEARCH), _caller(COLLIDE)


class Addresses(NamedTuple):
    """Addresses of what advances a world.

    Terms: search: for the pairs of each step, or 0 where the step finds them; sift: drops pairs that are apart, or 0; collide:
    answers convex pairs, or 0 to stop at them.
    """

    step: int
    search: int
    sift: int
    collide: int


@kernel
def advance_world(kernels: Addresses, floats: Floats, ints: Ints, place: Ints, w: int, left: Ints, status: Ints) -> int:
    """Advance world w by `left[w]` steps, as `World.step` does.

    Args: floats, ints: the arenas of all worlds in a row; place (k, 4): where those of each world begin and end.
    Returns: 0, or 1 where it stopped before; `left` and `status` then say where and why, as `World.step` reads it.
    """
    own_floats, own_ints = floats[place[w, 0] : place[w, 1]], ints[place[w, 2] : place[w, 3]]
    status[w] = DONE
    while left[w] > 0:
        done, status[w] = call_step(kernels.step, (own_floats, own_ints, left[w]))
        left[w] -= done
        if status[w] == SEARCH_PENDING:
            status[w] = call_search(kernels.search, (own_floats, own_ints))
            if status[w] == DONE and kernels.sift != 0:
                call_collide(kernels.sift, (own_floats, own_ints))
        elif status[w] == CONVEX_PENDING and kernels.collide != 0:
            call_collide(kernels.collide, (own_floats, own_ints))
            status[w] = DONE
        if status[w] != DONE:
            return 1
    return 0


@entry
def advance_worlds(
    addresses: tuple[Any, Any, Any, Any], floats: Floats, ints: Ints, place: Ints, which: Ints, left: Ints, status: Ints
) -> int:
    """Advance the worlds numbered `which`, one after the other.

    Args: addresses: as `Addresses`. Returns: how many stopped before.
    """
    kernels, stopped = Addresses(addresses[0], addresses[1], addresses[2], addresses[3]), 0
    for at in range(which.shape[0]):
        stopped += advance_world(kernels, floats, ints, place, which[at], left, status)
    return stopped


@parallel_entry
def advance_worlds_parallel(
    addresses: tuple[Any, Any, Any, Any], floats: Floats, ints: Ints, place: Ints, which: Ints, left: Ints, status: Ints,
    threads: int,
) -> int:  # fmt: skip
    """As `advance_worlds`, with a run of neighbouring worlds on each thread."""
    kernels, worlds = Addresses(addresses[0], addresses[1], addresses[2], addresses[3]), which.shape[0]
    for chunk in prange(threads):
        for at in range(chunk * worlds // threads, (chunk + 1) * worlds // threads):
            advance_world(kernels, floats, ints, place, which[at], left, status)
    stopped = 0
    for at in range(worlds):
        stopped += status[which[at]] != DONE
    return stopped
