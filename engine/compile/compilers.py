"""All that is used of Numba beyond its promises (over 400 lines: one file is read anew with a new version of Numba).

How it compiles, links, keeps and calls whole programs: Numba makes machine code of every function on its own, with all that it
calls, once per caller. Here a kernel stays what Numba made of its text until an entry is linked, which takes in every kernel
that it reaches, once, and is optimised as one program. That takes a fifth off the first step, and what comes out does not
depend on what else the process has compiled.

Nothing else of this project touches what Numba does not document; `INTERNALS` lists it, and a test says what a version lacks.
"""

import io
import pickle
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar, cast

from engine.compile.kernel_cache import read_checked, write_checked

__all__ = [
    "INTERNALS",
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
    "pointer_maker",
    "prepare",
    "stream_options",
    "use_cache",
]

Function = TypeVar("Function", bound=Callable[..., Any])

NUMBA_RUNTIME = "NRT_"
"""How the symbols that Numba shares among all functions of a process begin."""
ENVIRONMENT = "_ZN08NumbaEnv"
"""How the symbols begin under which a function finds the Python objects that it was compiled with."""

INTERNALS: dict[str, tuple[str, ...]] = {
    "numba.core.compiler.CompilerBase": ("define_pipelines",),
    "numba.core.compiler.DefaultPassBuilder": ("define_nopython_pipeline",),
    "numba.core.codegen.JITCodeLibrary": (
        *("codegen", "finalize", "enable_object_caching", "get_pointer_to_function", "_raise_if_finalized"),
        *("_finalize_dynamic_globals", "_get_module_for_linking", "_optimize_final_module"),
        *("_ensure_finalized", "_get_compiled_object", "serialize_using_object_code"),
    ),
    "numba.core.caching.IndexDataCacheFile": ("_data_path", "_load_data", "_load_index", "_open_for_write"),
    "numba.core.environment": ("lookup_environment",),
    "numba.core.runtime.nrt.rtsys": ("initialize",),
    "numba.core.types": ("FunctionType",),
    "numba.core.config": ("CACHE_DIR", "DISABLE_JIT", "NUMBA_NUM_THREADS"),
    "numba.np.arrayobj": (),
    "the options of njit": ("forceinline", "no_cfunc_wrapper", "no_cpython_wrapper", "pipeline_class"),
    "the type of a function": ("ftype",),
    "a compiled function": ("compile", "get_call_template", "get_compile_result", "_cache"),
    "its cache": ("load_overload", "_cache_file", "_guard_against_spurious_io_errors", "_impl", "_load_overload"),
    "where its cache lies": ("filename_base", "locator"),
    "what says where": ("_cache_path",),
    "the files of its cache": ("_index_path", "_source_stamp", "_version"),
    "what its compiler made": ("fndesc", "library", "signature"),
    "its description": ("llvm_cfunc_wrapper_name",),
    "its library": ("_codegen", "_final_module", "_finalized", "_linking_libraries", "_reload_init"),
    "the machine code that it is made with": ("set_env",),
    "its compiler": ("state",),
    "the state of its compiler": ("flags", "func_id", "library", "targetctx"),
    "the flags of its compiler": ("noalias",),
    "the function in its compiler": ("func_qualname",),
    "its target": ("codegen", "get_dummy_value", "get_value_type"),
}
"""All that is used here of Numba and that Numba does not document: by where it is, or by what has it, its names."""


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

    def prepare(state: Any) -> None:
        state["library"] = _kernel_library()(state.targetctx.codegen(), state.func_id.func_qualname)

    return _compiler(prepare)


@cache
def stream_compiler() -> type:
    """Numba's compiler with the promise that arrays do not overlap, which it knows as a flag but not as an option.

    It optimises such a function before the entry takes it in: rays are a fifth faster that way.
    """

    def prepare(state: Any) -> None:
        state.flags.noalias = True

    return _compiler(prepare)


@cache
def entry_compiler() -> type:
    """Numba's compiler for functions that Python calls: they keep the kernels they were linked with to themselves.

    Otherwise a loaded function would call those copies of a kernel that the process has met first, which come from another
    context and may round otherwise: a step would give other bits in the process that compiled it.
    """

    def prepare(state: Any) -> None:
        library = _entry_library()(state.targetctx.codegen(), state.func_id.func_qualname)
        library.enable_object_caching()
        state["library"] = library

    return _compiler(prepare)


def entry_options() -> dict[str, Any]:
    """What `njit` is told of a function that Python calls."""
    return {"pipeline_class": entry_compiler()}


def kernel_options() -> dict[str, Any]:
    """What `njit` is told of a function that only compiled functions call."""
    return {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": kernel_compiler()}


def stream_options() -> dict[str, Any]:
    """As `kernel_options`, where arrays do not overlap."""
    return kernel_options() | {"pipeline_class": stream_compiler()}


def inlined_options() -> dict[str, Any]:
    """As `kernel_options`, put in place of every call."""
    return kernel_options() | {"forceinline": True}


def _compiler(prepare: Callable[[Any], None]) -> type:
    """Numba's compiler, its state prepared before the passes are chosen."""
    from numba.core.compiler import CompilerBase, DefaultPassBuilder

    class Compiler(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            state: Any = self.state
            prepare(state)
            passes: Any = DefaultPassBuilder
            return [passes.define_nopython_pipeline(state)]

    return Compiler


@cache
def _kernel_library() -> type:
    """What a kernel is compiled into: a module to be linked, without machine code."""
    from numba.core.codegen import JITCodeLibrary

    library: Any = JITCodeLibrary

    class KernelLibrary(library):  # type: ignore[misc]  # Numba's stubs do not know it
        @property
        def codegen(self) -> Any:
            """Takes no environment: the entry sets those of all its kernels."""
            return SimpleNamespace(set_env=lambda _name, _environment: None)

        def finalize(self) -> None:
            self._raise_if_finalized()
            self._finalize_dynamic_globals()
            self._finalized = True

        def alone(self) -> Any:
            """The module of this kernel, without what it calls."""
            return super()._get_module_for_linking()

        def _get_module_for_linking(self) -> Any:
            """For the libraries that Numba makes of the bodies of parallel loops: with all that it calls."""
            whole = self.alone().clone()
            _link(whole, self._linking_libraries)
            return whole

        def get_pointer_to_function(self, _name: str) -> int:
            """Nothing that could be called: 0."""
            return 0

    return KernelLibrary


@cache
def _entry_library() -> type:
    """What an entry is compiled into: one program with every kernel that it reaches."""
    from llvmlite.binding import parse_assembly
    from numba.core import environment
    from numba.core.codegen import JITCodeLibrary

    library: Any = JITCodeLibrary
    numba_environment: Any = environment

    class EntryLibrary(library):  # type: ignore[misc]  # Numba's stubs do not know it
        def finalize(self) -> None:
            for one in _link(self._final_module, self._linking_libraries):
                self._reload_init.update(one._reload_init)
            self._linking_libraries: list[Any] = []
            super().finalize()
            for one in self._final_module.global_variables:
                found = numba_environment.lookup_environment(one.name) if one.name.startswith(ENVIRONMENT) else None
                if found is not None:
                    self._codegen.set_env(one.name, found)

        def _optimize_final_module(self) -> None:
            for one in self._final_module.functions:
                if one.linkage.name in {"linkonce_odr", "weak_odr"} and not one.name.startswith(NUMBA_RUNTIME):
                    # The bodies of parallel loops are among them: the process that compiles has those in a library apart.
                    # Not 'internal': the loader would find those by name, for callers that do not know what became of them.
                    one.linkage = "private"
            super()._optimize_final_module()

        def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
            """As Numba keeps it, with the names that Python asks for in place of the program, which no other takes in.

            To read the program was half of the first step of a robot on the ground where machine code is kept.
            """
            self._ensure_finalized()
            defined = [one for one in self._final_module.functions if not one.is_declaration]
            exported = [one.name for one in defined if one.linkage.name == "external"]
            bodies = "\n".join(f'define void @"{name}"() {{ ret void }}' for name in exported)
            return self.name, "object", (self._get_compiled_object(), parse_assembly(bodies).as_bitcode())

    return EntryLibrary


def _link(module: Any, libraries: list[Any]) -> list[Any]:
    """Take the libraries into a module, and through kernels all that those call, each once. Returns: all that were taken."""
    taken: dict[Any, None] = {}
    ahead = list(reversed(libraries))
    while ahead:
        one = ahead.pop()
        if one in taken:
            continue
        taken[one] = None
        if isinstance(one, _kernel_library()):
            kernel: Any = one
            module.link_in(kernel.alone(), preserve=True)
            ahead.extend(reversed(kernel._linking_libraries))
        else:
            module.link_in(one._get_module_for_linking(), preserve=True)
    return list(taken)


def for_all_values(function: Function) -> Function:
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
            given = [builder.extract_value(values[1], k) for k in range(len(signature.args))]
            answer = builder.call(builder.inttoptr(values[0], pointer), given)
            return context.get_dummy_value() if signature.return_type == types.none else answer

        return signature.return_type(address, arguments), code

    return cast(Callable[..., Any], call)


def pointer_maker(number: Any) -> Callable[..., Any]:
    """How compiled code takes an address [bytes] for a pointer to numbers of a type.

    Nothing counts who uses what lies there, as Numba does with arrays for each function that they are handed to: that costs a
    quarter of the step of a free body.
    """
    import numba
    from numba.extending import intrinsic

    types: Any = numba.types
    pointer = types.CPointer(number)

    @intrinsic
    def at(_: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, _: Any, values: Any) -> Any:
            return builder.inttoptr(values[0], context.get_value_type(pointer))

        return pointer(address), code

    return cast(Callable[..., Any], at)
