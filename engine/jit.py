"""Compile a numerical function with Numba, in a cache that can never serve code of an older source.

Numba keys its cache by the file of the outermost function alone, so that an edited callee or another flag would go unnoticed.
Here the directory itself carries a hash of all sources of this package, the flags and Numba's version.

With ``NUMBA_DISABLE_JIT=1`` the same functions run as plain Python.
"""

import fcntl
import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import platformdirs

from engine.sources import source_digest

__all__ = ["FLAGS", "cache_directory", "entry", "inlined", "jit_is_off", "kernel", "parallel_entry", "stream"]

Function = TypeVar("Function", bound=Callable[..., Any])

FLAGS: frozenset[str] = frozenset({"contract", "nsz"})
"""Fused multiply-add and unsigned zeros. Nothing that hides NaN or infinity, nothing that reorders sums."""
NUMBA_RUNTIME = "NRT_"
"""How the symbols that Numba shares among all functions of a process begin."""


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
    return _once_for_all_values(_compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True))


def stream(function: Function) -> Function:
    """A kernel whose array arguments do not overlap, so that the compiler may take several steps of a loop at once.

    Args: function: numbers, tuples and arrays only; no array shares memory with another that is written.
    Returns: the same function, compiled on first use for the argument types that it meets.
    """
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=_apart())


def inlined(function: Function) -> Function:
    """As `kernel`, put in place of every call: for what costs less than handing over its arrays."""
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True)


def entry(function: Function) -> Function:
    """A compiled function that Python calls, kept on disk for the next process.

    Processes that need it at the same time compile it once: the others wait and load it.

    Args: function: numbers, tuples and arrays only.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    return _one_at_a_time(_compiled(function, cache=True, pipeline_class=_closed()))


def parallel_entry(function: Function) -> Function:
    """As `entry`, with the loops over `numba.prange` shared out among threads, and nothing else.

    Args: function: its `prange` loops must write to places of their own only, so that no order of threads can be seen.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    no_more = dict.fromkeys(("comprehension", "reduction", "inplace_binop", "setitem", "numpy", "stencil", "fusion"), False)
    parallel = {"prange": True, **no_more}
    return _one_at_a_time(_compiled(function, cache=True, parallel=parallel, pipeline_class=_closed()))


@cache
def _closed() -> type:
    """Numba's compiler for functions that keep the kernels they were linked with to themselves.

    Otherwise a loaded function would call those copies of a kernel that the process has met first, which come from another
    context and may round otherwise: a step would give other bits in the process that compiled it.
    """
    from numba.core.compiler import CompilerBase, DefaultPassBuilder

    class Closed(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            state: Any = self.state
            library = state.targetctx.codegen().create_library(state.func_id.func_qualname)
            library.enable_object_caching()
            optimize = library._optimize_final_module

            def close_and_optimize() -> None:
                for one in library._final_module.functions:
                    if one.linkage.name in {"linkonce_odr", "weak_odr"} and not one.name.startswith(NUMBA_RUNTIME):
                        # The bodies of parallel loops are among them: the process that compiles has those in a library apart.
                        # Not 'internal': the loader would find those by name, for callers that do not know what became of them.
                        one.linkage = "private"
                optimize()

            library._optimize_final_module = close_and_optimize
            state.library = library
            passes: Any = DefaultPassBuilder
            return [passes.define_nopython_pipeline(state)]

    return Closed


@cache
def _apart() -> type:
    """Numba's compiler with the promise that arrays do not overlap, which it knows as a flag but not as an option."""
    from numba.core.compiler import CompilerBase, DefaultPassBuilder

    class Apart(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            self.state.flags.noalias = True
            passes: Any = DefaultPassBuilder
            return [passes.define_nopython_pipeline(self.state)]

    return Apart


def _compiled(function: Function, **options: bool | type | dict[str, bool]) -> Function:
    """The function under Numba with the flags of this package; Numba's stubs do not know all options, hence Any."""
    import numba

    njit: Any = numba.njit
    return cast(Function, njit(fastmath=set(FLAGS), error_model="numpy", nogil=True, **options)(function))


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
            return compiler(signature)

    cast(Any, function).compile = locked
    return function
