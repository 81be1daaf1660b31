"""Compile a numerical function with Numba, in a cache that can never serve code of an older source.

Numba keys its cache by the file of the outermost function alone, so that an edited callee or another flag would go unnoticed.
Here the directory itself carries a hash of all sources of this package, the flags and Numba's version.

With ``NUMBA_DISABLE_JIT=1`` the same functions run as plain Python.
"""

import fcntl
import gc
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import platformdirs

from engine.compilers import entry_compiler, kernel_compiler, stream_compiler
from engine.kernel_cache import check_files
from engine.sources import source_digest

__all__ = [
    "FLAGS",
    "cache_directory",
    "entry",
    "inlined",
    "jit_is_off",
    "kernel",
    "parallel_entry",
    "rounding_kernel",
    "stream",
]

Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: frozenset[str] = frozenset({"contract", "nsz"})
"""Fused multiply-add and unsigned zeros. Nothing that hides NaN or infinity, nothing that reorders sums."""


def cache_directory() -> Path:
    """The directory for compiled code of exactly these sources, flags and this Numba.

    Returns: `$PLUMBLINE_KERNEL_CACHE` or the user's cache directory, with the hash appended.
    """
    import numba

    key = " ".join((source_digest(), *sorted(FLAGS), numba.__version__))
    digest = hashlib.sha256(key.encode())
    root = os.environ.get("PLUMBLINE_KERNEL_CACHE") or platformdirs.user_cache_dir("plumbline")
    return Path(root) / f"kernels-{digest.hexdigest()[:16]}"


def jit_is_off() -> bool:
    """Whether functions run as plain Python."""
    import numba

    return bool(numba.config.__dict__["DISABLE_JIT"])


def _prepare() -> None:
    """Point Numba to the cache; must run before the first function is decorated."""
    import numba

    numba.config.__dict__["CACHE_DIR"] = str(cache_directory())


_prepare()


def kernel(function: Function) -> Function:
    """A compiled function that other compiled functions call, and Python cannot.

    Args: function: numbers, tuples and arrays only.
    Returns: the same function, compiled on first use for the argument types that it meets.
    """
    return _once_for_all_values(
        _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=kernel_compiler())
    )


def rounding_kernel(function: Function) -> Function:
    """As `kernel`, with every operation rounded by itself, whoever calls it: for arithmetic that lives on its own rounding."""
    plain: set[str] = set()
    return _once_for_all_values(
        _compiled(function, fastmath=plain, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=kernel_compiler())
    )


def stream(function: Function) -> Function:
    """A kernel whose array arguments do not overlap, so that the compiler may take several steps of a loop at once.

    Args: function: numbers, tuples and arrays only; no array shares memory with another that is written.
    Returns: the same function, compiled on first use for the argument types that it meets.
    """
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=stream_compiler())


def inlined(function: Function) -> Function:
    """As `kernel`, put in place of every call: for what costs less than handing over its arrays."""
    return _compiled(
        function, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, pipeline_class=kernel_compiler()
    )


def entry(function: Function) -> Function:
    """A compiled function that Python calls, kept on disk for the next process.

    Processes that need it at the same time compile it once: the others wait and load it.

    Args: function: numbers, tuples and arrays only.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    return _loaded_lightly(_one_at_a_time(_compiled(function, cache=True, pipeline_class=entry_compiler())))


def parallel_entry(function: Function) -> Function:
    """As `entry`, with the loops over `numba.prange` shared out among threads, and nothing else.

    Args: function: its `prange` loops must write to places of their own only, so that no order of threads can be seen.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    no_more = dict.fromkeys(("comprehension", "reduction", "inplace_binop", "setitem", "numpy", "stencil", "fusion"), False)
    parallel = {"prange": True, **no_more}
    return _loaded_lightly(_one_at_a_time(_compiled(function, cache=True, parallel=parallel, pipeline_class=entry_compiler())))


def _compiled(function: Function, **options: bool | type | dict[str, bool] | set[str]) -> Function:
    """The function under Numba, by default with the flags of this package; its stubs do not know all options, hence Any."""
    import numba

    njit: Any = numba.njit
    return cast(Function, njit(**{"fastmath": set(FLAGS), "error_model": "numpy", "nogil": True, **options})(function))


def _once_for_all_values(function: Function) -> Function:
    """The compiled function that callers meet by the types of arguments alone.

    Numba would compile it anew for each constant that a caller passes, `load3` for each column; inlining does that better.
    """
    template = getattr(function, "get_call_template", None)
    if template is None:
        return function

    import numba

    unliteral: Any = numba.types.unliteral

    def by_type(args: Any, kws: Any) -> Any:
        return template(tuple(unliteral(one) for one in args), {name: unliteral(one) for name, one in kws.items()})

    cast(Any, function).get_call_template = by_type
    return function


def _one_at_a_time(function: Function) -> Function:
    """The compiled function with its compiler, which looks into the cache first, behind a lock of its own."""
    compiler = getattr(function, "compile", None)
    if compiler is None:
        return function

    def locked(signature: Any) -> Any:
        directory = cache_directory()
        directory.mkdir(parents=True, exist_ok=True)
        with (directory / f"{function.__name__}.lock").open("w") as stream:
            fcntl.flock(stream, fcntl.LOCK_EX)
            with _nothing_collected():
                return compiler(signature)

    cast(Any, function).compile = locked
    return function


@contextmanager
def _nothing_collected() -> Iterator[None]:
    """Python's search for cyclic garbage held back: a seventh of the time of a compilation, for 140 MB while it lasts."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def _loaded_lightly(function: Function) -> Function:
    """The compiled function that comes from the cache without the compiler's own preparations.

    Before it looks into the cache, Numba imports all that it may compile, SciPy's linear algebra among it: 0.26 s of 0.36 s to
    the first step of ten boxes. What is compiled needs none of it, and the compiler itself prepares again.
    """
    cache = getattr(function, "_cache", None)
    if cache is None:
        return function

    from numba.core.runtime.nrt import rtsys

    check_files(cache)
    runtime: Any = rtsys

    def load(signature: Any, context: Any) -> Any:
        runtime.initialize(context)
        with cache._guard_against_spurious_io_errors():
            return cache._load_overload(signature, context)

    cache.load_overload = load
    return function
