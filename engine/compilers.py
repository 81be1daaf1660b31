"""How Numba compiles and links the functions of this package: whole programs, each of them by itself.

Numba makes machine code of every function on its own, with all that it calls, once per caller. Here a kernel stays what Numba
made of its text until an entry is linked, which takes in every kernel that it reaches, once, and is optimised as one program.
That takes a fifth off the first step, and what comes out does not depend on what else the process has compiled.
"""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

__all__ = ["entry_compiler", "kernel_compiler", "stream_compiler"]

NUMBA_RUNTIME = "NRT_"
"""How the symbols that Numba shares among all functions of a process begin."""
ENVIRONMENT = "_ZN08NumbaEnv"
"""How the symbols begin under which a function finds the Python objects that it was compiled with."""


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
