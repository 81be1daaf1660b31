"""Compile a numerical function with Numba, in a cache that can never serve code of an older source.

Numba keys its cache by the file of the outermost function alone, so that an edited callee would go unnoticed. Here the
directory itself carries a hash of Numba's version and the sources that the function is made of: its file and all that this
imports. What an edit cannot reach is not compiled again, nor is what lies elsewhere or was written anew.

Every operation is rounded by itself, as the text says: no flag of the compiler lets it do otherwise. `linker` makes a first
step quick with what Numba does not document; where that is unknown, or switched off, Numba's own `njit` gives the same bits.
With ``NUMBA_DISABLE_JIT=1`` the same functions run as plain Python.
"""

import fcntl
import gc
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

from plumbline.engine.compile.kernel_cache import make_directory, root
from plumbline.engine.compile.sources import closure_digest

Function = TypeVar("Function", bound=Callable[..., Any])

LINKED = ("0.68",)
"""The versions of Numba whose undocumented parts `linker` has been tested with."""
SWITCH = "PLUMBLINE_LINKER"
"""The variable that switches the linker off."""
OPTIONS = {"error_model": "numpy", "nogil": True}


@cache
def linker() -> Any:
    """What links kernels into an entry as one program; None where nothing is compiled, or it is off, or Numba is unknown."""
    import numba

    if numba.__version__.rpartition(".")[0] not in LINKED or jit_is_off() or os.environ.get(SWITCH) == "off":
        return None
    from plumbline.engine.compile import linker as found

    return found


def jit_is_off() -> bool:
    """Whether functions run as plain Python."""
    return bool(_config().DISABLE_JIT)


def most_threads() -> int:
    """How many threads Numba may use in this process."""
    return int(_config().NUMBA_NUM_THREADS)


def prepare() -> None:
    """Import what Numba imports when it first compiles or loads a function of arrays."""
    import_module("numba.np.arrayobj")


@cache
def cache_directory(path: Path) -> Path:
    """The directory for the compiled functions of a source file, for exactly its sources, this Numba and the way of compiling.

    Returns: a directory in `kernel_cache.root`, named by the hash; it may not be there.
    """
    import numba

    name = str(path).removeprefix(str(Path(__file__).parents[1]))
    way = "linked" if linker() else "apart"
    digest = hashlib.sha256(" ".join((name, closure_digest(path), way, numba.__version__)).encode())
    return root() / f"kernels-{digest.hexdigest()[:16]}"


def kernel(function: Function) -> Function:
    """A compiled function that other compiled functions call, and Python cannot.

    Args: function: numbers, tuples and arrays only.
    Returns: the same function, compiled on first use for the argument types that it meets.
    """
    return _linked(function, "kernel")


def seldom(function: Function) -> Function:
    """As `kernel`, off the way that most steps take: compiled small and called, so that what calls it stays small too."""
    return _linked(function, "seldom")


def stream(function: Function) -> Function:
    """A kernel whose array arguments do not overlap, so that the compiler may take several steps of a loop at once.

    Args: function: numbers, tuples and arrays only; no array shares memory with another that is written.
    Returns: the same function, compiled on first use for the argument types that it meets.
    """
    return _compiled(function, **(linker().OPTIONS["stream"] if linker() else {}))


def inlined(function: Function) -> Function:
    """As `kernel`, in place of every call before anything is optimised: for what costs less than handing over its arrays."""
    return _linked(function, "inlined")


def template(function: Function) -> Function:
    """A body that entries share, written into each of them with the functions that it is handed before anything is compiled.

    Its loops over `numba.prange` are shared out where the entry's are, and the entry is kept on disk as if it had been written
    out; a kernel could not have either.
    """
    return _compiled(function, inline="always")


def entry(function: Function) -> Function:
    """A compiled function that Python calls, kept on disk for the next process.

    Processes that need it at the same time compile it once: the others wait and load it.

    Args: function: numbers, tuples and arrays only.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    return _kept(function)


def parallel_entry(function: Function) -> Function:
    """As `entry`, with the loops over `numba.prange` shared out among threads, and nothing else.

    Args: function: its `prange` loops must write to places of their own only, so that no order of threads can be seen.
    Returns: the same function, compiled on first use or loaded from the cache.
    """
    no_more = dict.fromkeys(("comprehension", "reduction", "inplace_binop", "setitem", "numpy", "stencil", "fusion"), False)
    return _kept(function, parallel={"prange": True, **no_more})


def _config() -> Any:
    import numba

    return numba.config


def _compiled(function: Function, **options: Any) -> Function:
    """The function under Numba, whose stubs do not know all options, hence Any."""
    import numba

    njit: Any = numba.njit
    return cast(Function, njit(**{**OPTIONS, **options})(function))


def _linked(function: Function, kind: str) -> Function:
    """The function for other compiled functions, by the linker where there is one."""
    link = linker()
    if link is None:
        return _compiled(function)
    return cast(Function, link.for_all_values(_compiled(function, **link.OPTIONS[kind])))


def _kept(function: Function, **options: Any) -> Function:
    """The entry with its way from and to the disk."""
    directory = cache_directory(Path(function.__code__.co_filename))
    link = linker()
    if link is None:
        _config().CACHE_DIR = str(directory)
        with suppress(OSError):
            make_directory(directory)
        return _compiled(function, cache=True, **options)
    made = _compiled(function, **link.OPTIONS["entry"], **options)
    return cast(Function, link.kept(made, directory, partial(_one_at_a_time, directory)))


@contextmanager
def _one_at_a_time(directory: Path, name: str) -> Iterator[None]:
    """A function's compiler behind a lock of its own, which processes share, unless the directory is read-only."""
    with ExitStack() as held:
        with suppress(OSError):
            make_directory(directory)
            fcntl.flock(held.enter_context((directory / f"{name}.lock").open("w")), fcntl.LOCK_EX)
        held.enter_context(_nothing_collected())
        yield


@contextmanager
def _nothing_collected() -> Iterator[None]:
    """Python's search for cyclic garbage held back: a seventh of the time of a compilation.

    What was left by then counts as old, which is looked through when there is a quarter more of it, rather than at once.
    """
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            if gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()
            gc.enable()
