"""What this project asks of Numba: compilers for kernels and entries, and ways to keep, load and call what they make.

Nothing else of this project touches what Numba does not document but the files of this folder that `internals` names; it lists
all that they use of it, and a test says what a version lacks.
"""

import io
import pickle
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast

from engine.compile.kernel_cache import read_checked, write_checked

__all__ = [
    "checked_files",
    "compiled_under",
    "entry_options",
    "entry_point",
    "for_all_values",
    "inlined_options",
    "jit_is_off",
    "kernel_options",
    "loaded_lightly",
    "most_threads",
    "pointer_caller",
    "prepare",
    "seldom_options",
    "stream_options",
    "table_finder",
    "use_cache",
]

Function = TypeVar("Function", bound=Callable[..., Any])


def jit_is_off() -> bool:
    """Whether functions run as plain Python."""
    return bool(_config().DISABLE_JIT)


def most_threads() -> int:
    """How many threads Numba may use in this process."""
    return int(_config().NUMBA_NUM_THREADS)


def use_cache(directory: str) -> None:
    """Keep what is decorated from now on in a directory."""
    _config().CACHE_DIR = directory


def _config() -> Any:
    import numba

    return numba.config


def prepare() -> None:
    """Import what Numba imports when it first compiles or loads a function of arrays."""
    import_module("numba.np.arrayobj")


@cache
def kernel_compiler() -> type:
    """Numba's compiler for functions that are only ever linked into others."""
    return _compiler(_into_kernel, _kernel_passes)


@cache
def seldom_compiler() -> type:
    """As `kernel_compiler`, for functions that stay functions, and small."""

    def prepare(state: Any) -> None:
        _into_kernel(state)
        state.library.seldom = True

    return _compiler(prepare, _kernel_passes)


@cache
def stream_compiler() -> type:
    """Numba's compiler with the promise that arrays do not overlap, which it knows as a flag but not as an option.

    It optimises such a function before the entry takes it in.
    """

    def prepare(state: Any) -> None:
        state.flags.noalias = True

    return _compiler(prepare, _usual_passes)


@cache
def entry_compiler() -> type:
    """Numba's compiler for functions that Python calls: they keep the kernels they were linked with to themselves.

    Otherwise a loaded function would call those copies of a kernel that the process has met first, which come from another
    context and may round otherwise: a step would give other bits in the process that compiled it.
    """

    def prepare(state: Any) -> None:
        from engine.compile.libraries import EntryLibrary

        state.library = EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()

    return _compiler(prepare, _usual_passes)


def _into_kernel(state: Any) -> None:
    """Have a function compiled into a module that waits to be linked."""
    from engine.compile.libraries import KernelLibrary

    state.library = KernelLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
    state.library.inline = not state.flags.forceinline


def _kernel_passes(_state: Any) -> Any:
    from engine.compile.passes import kernel_passes

    return kernel_passes()


def _usual_passes(state: Any) -> Any:
    from numba.core.compiler import DefaultPassBuilder

    builder: Any = DefaultPassBuilder
    return builder.define_nopython_pipeline(state)


def _compiler(prepare: Callable[[Any], None], passes: Callable[[Any], Any]) -> type:
    """A compiler of these passes, its state prepared before they are chosen."""
    from numba.core.compiler import CompilerBase

    base: Any = CompilerBase

    class Compiler(base):  # type: ignore[misc]  # Numba's stubs do not know it
        def define_pipelines(self) -> list[Any]:
            prepare(self.state)
            return [passes(self.state)]

    return Compiler


def entry_options() -> dict[str, Any]:
    """What `njit` is told of a function that Python calls."""
    return {"pipeline_class": entry_compiler()}


def kernel_options() -> dict[str, Any]:
    """What `njit` is told of a function that only compiled functions call."""
    return {"forceinline": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": kernel_compiler()}


def seldom_options() -> dict[str, Any]:
    """As `kernel_options`, never put in place of a call."""
    return kernel_options() | {"pipeline_class": seldom_compiler()}


def stream_options() -> dict[str, Any]:
    """As `kernel_options`, where arrays do not overlap."""
    return kernel_options() | {"pipeline_class": stream_compiler()}


def inlined_options() -> dict[str, Any]:
    """As `kernel_options`, put in place of every call."""
    return kernel_options() | {"forceinline": True}


def for_all_values(function: Function) -> Function:
    """The compiled function that callers meet by the types of arguments alone, arrays as tables.

    Numba would compile it anew for each constant that a caller passes, `load3` for each column; inlining does that better.
    """
    template = getattr(function, "get_call_template", None)
    if template is None:
        return function

    known: dict[Any, Any] = {}

    def by_type(args: Any, kws: Any) -> Any:
        from engine.compile.table_type import as_given

        given = as_given(args), tuple((name, *as_given((one,))) for name, one in kws.items())
        if given not in known:
            known[given] = template(given[0], dict(given[1]))
        return known[given]

    cast(Any, function).get_call_template = by_type
    return function


def compiled_under(function: Function, around: Callable[[str], AbstractContextManager[None]]) -> Function:
    """The compiled function whose compiler, which looks into the cache first, runs within `around(name of the function)`."""
    compiler = getattr(function, "compile", None)
    if compiler is None:
        return function

    def guarded(signature: Any) -> Any:
        with around(function.__name__):
            return compiler(signature)

    cast(Any, function).compile = guarded
    return function


def loaded_lightly(function: Function, directory: Path) -> Function:
    """The compiled function that comes from its cache without the compiler's own preparations.

    Before it looks into the cache, Numba imports all that it may compile, SciPy's linear algebra among it: 0.26 s of 0.36 s to
    the first step of ten boxes. What is compiled needs none of it, and the compiler itself prepares again.

    Args: directory: for exactly this source, so that neither where the source lies nor when it was written matters. Numba asks
    for both, and a fresh checkout of the same sources would compile everything anew.
    """
    cache = getattr(function, "_cache", None)
    if cache is None:
        return function

    from numba.core.runtime.nrt import rtsys

    cache._impl.locator._cache_path = str(directory)
    cache._cache_file = checked_files()(str(directory), cache._impl.filename_base, ())
    runtime: Any = rtsys

    def load(signature: Any, context: Any) -> Any:
        runtime.initialize(context)
        with cache._guard_against_spurious_io_errors():
            return cache._load_overload(signature, context)

    cache.load_overload = load
    return function


@cache
def checked_files() -> type:
    """Numba's index and data files, each with a digest: what was damaged is compiled anew, never run."""
    from numba.core.caching import IndexDataCacheFile

    files: Any = IndexDataCacheFile

    class Checked(files):  # type: ignore[misc]  # Numba is untyped
        def _load_index(self) -> dict[Any, str]:
            try:
                content = read_checked(Path(self._index_path))
            except FileNotFoundError:
                return {}
            if content is None:
                return {}
            stream = io.BytesIO(content)
            if pickle.load(stream) != self._version:
                return {}
            stamp, overloads = pickle.loads(stream.read())
            return overloads if stamp == self._source_stamp else {}

        def _load_data(self, name: str) -> Any:
            path = Path(self._data_path(name))
            content = read_checked(path)
            if content is None:
                raise OSError(f"{path}: damaged")  # what Numba takes for a file that is not there
            return pickle.loads(content)

        @contextmanager
        def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
            buffer = io.BytesIO()
            yield buffer
            write_checked(Path(filepath), buffer.getvalue())

    return Checked


def entry_point(function: Any, signature: Any) -> tuple[Any, int]:
    """What a compiled function returns for arguments of these types, and where the machine code for them lies.

    It is compiled as a call from Python compiles it: asked for by what it returns too, it would be compiled and kept twice.
    """
    function.compile(tuple(signature.args))
    made = function.get_compile_result(signature)
    library = made._asdict()["library"]
    return made.signature.return_type, library.get_pointer_to_function(made.fndesc.llvm_cfunc_wrapper_name)


def pointer_caller(signature: Any) -> Callable[..., Any]:
    """How compiled code calls a function of this signature: by its address, with a tuple of arguments."""
    import numba
    from numba.extending import intrinsic

    types: Any = numba.types

    @intrinsic
    def call(_: Any, address: Any, arguments: Any) -> Any:
        def code(context: Any, builder: Any, _: Any, values: Any) -> Any:
            pointer = context.get_value_type(types.FunctionType(signature).ftype)
            given = [
                context.cast(builder, builder.extract_value(values[1], k), arguments[k], asked)
                for k, asked in enumerate(signature.args)
            ]
            answer = builder.call(builder.inttoptr(values[0], pointer), given)
            return context.get_dummy_value() if signature.return_type == types.none else answer

        return signature.return_type(address, arguments), code

    return cast(Callable[..., Any], call)


def table_finder() -> Callable[..., Any]:
    """How compiled code finds a table within numbers in a row: (numbers, start, rows, columns)."""
    from numba.extending import intrinsic

    @intrinsic
    def find(_: Any, numbers: Any, _start: Any, _rows: Any, _columns: Any) -> Any:
        from engine.compile.table_type import within

        return within(numbers)

    return cast(Callable[..., Any], find)
